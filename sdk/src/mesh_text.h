#pragma once

#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/text.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <fmt/format.h>
#include <span>
#include <string>
#include <string_view>

/// \file Lines of the text mesh formats, and what their readers share.

namespace fresco::detail
{

inline std::string_view as_text(std::span<const std::byte> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A word as it may appear in a message: cut to 40 characters, control characters shown as '?'.
inline std::string in_quotes(std::string_view word)
{
    std::string text = "'";
    for (const char c : word.substr(0, 40))
        text += (c >= ' ' && c <= '~') ? c : '?';
    return text + (word.size() > 40 ? "...'" : "'");
}

/// Walks over the lines of a text held by the caller. A line ends in LF or CRLF, or in CR where the text has no LF. A last line
/// without an end looks like a truncated one: it is an error, unless the caller judges it.
class Lines
{
  public:
    Lines(std::string_view text, std::string_view source, std::size_t lines_before = 0, bool judges_last = false)
        : text_(text), source_(source), number_(lines_before), judges_last_(judges_last),
          end_(text.find('\n') == std::string_view::npos ? '\r' : '\n')
    {
    }

    /// The next line without its end; false at the end of the text.
    bool next(std::string_view& line)
    {
        if (offset_ == text_.size())
            return false;
        ++number_;
        std::size_t end = text_.find(end_, offset_);
        is_open_ = end == std::string_view::npos;
        if (is_open_ && !judges_last_)
            fail_open();
        end = std::min(end, text_.size());
        line = text_.substr(offset_, end - offset_);
        if (!line.empty() && line.back() == '\r')
            line.remove_suffix(1);
        offset_ = std::min(end + 1, text_.size());
        return true;
    }

    std::size_t number() const { return number_; }  ///< Number of the last line, counted from 1.
    std::size_t offset() const { return offset_; }  ///< Offset of the next line.

    bool is_open() const { return is_open_; }  ///< Whether the last line has no end.

    [[noreturn]] void fail_open() const { fail("the line is not ended by a newline: the file is cut; copy or export it again"); }
    [[noreturn]] void fail(const std::string& what) const { fail_at(number_, what); }
    [[noreturn]] void fail_at(std::size_t line, const std::string& what) const
    {
        throw Error(fmt::format("{}:{}: {}", source_, line, what));
    }

  private:
    std::string_view text_;
    std::string_view source_;
    std::size_t offset_ = 0;
    std::size_t number_;
    bool judges_last_;
    bool is_open_ = false;
    char end_;
};

/// Cuts polygons into fans of triangles and counts what had to be changed. Its callers check indices and limits.
class TriangleFan
{
  public:
    /// `keeps_degenerate`: also triangles that name a vertex twice.
    TriangleFan(MeshReadReport& report, bool keeps_degenerate) : report_(report), keeps_degenerate_(keeps_degenerate) {}

    /// Calls `triangle(a, b, c)` with positions into `corners`, which holds three vertex indices or more.
    template <class F>
    void split(std::span<const std::uint32_t> corners, F&& triangle)
    {
        if (corners.size() > 3)
            ++report_.polygons_split;
        for (std::size_t i = 2; i < corners.size(); ++i)
        {
            const std::uint32_t a = corners[0];
            const std::uint32_t b = corners[i - 1];
            const std::uint32_t c = corners[i];
            if (!keeps_degenerate_ && (a == b || b == c || c == a))
                ++report_.degenerate_dropped;
            else
                triangle(std::size_t{0}, i - 1, i);
        }
    }

  private:
    MeshReadReport& report_;
    bool keeps_degenerate_;
};

/// parse_ply with a choice: the store's own files keep faces that name a vertex twice, so that face numbers stay what they were,
/// and their offset.
/// `materials`: empty, or null if the caller wants none.
Mesh parse_ply_faces(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report,
                     bool keeps_degenerate, MeshMaterials* materials = nullptr, PlyIntegers* integers = nullptr);

}  // namespace fresco::detail
