#pragma once

#include "pipeline/pipeline.h"
#include "pipeline/problems.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

/// \file YAML as pipeline files may have it, with the place of every value. yaml-cpp parses it; what yaml-cpp takes in
/// silence and a pipeline must not hold (aliases, duplicate keys, depth) is refused here.

namespace fresco::host
{

/// Source of a piece of YAML.
struct YamlSource
{
    std::string name;              ///< As shown in problems: the file, or "--set NAME=…".
    std::filesystem::path folder;  ///< Base of relative paths; absolute.
    bool command_line = false;     ///< No lines, and a number or word is taken as text where text is wanted.
};

/// Position of a piece of YAML.
struct YamlPlace
{
    int line = 0;  ///< From 1; of a null value that of its key; 0 on the command line.
    int column = 0;
    std::shared_ptr<const YamlSource> source;

    operator Position() const { return {source ? source->name : std::string(), line, column}; }
};

/// One node of a YAML document, not yet resolved to a type: what a plain word means depends on the option that it is given to.
struct YamlNode : YamlPlace
{
    enum class Kind
    {
        null,
        scalar,
        list,
        map,
        invalid  ///< Already reported; to be passed over in silence.
    };
    struct Entry;

    YamlNode();
    explicit YamlNode(Kind node_kind, const YamlPlace& place = {});
    void stand_at(const YamlPlace& place) { static_cast<YamlPlace&>(*this) = place; }

    Kind kind = Kind::null;
    std::string text;    ///< Text of a scalar.
    bool plain = false;  ///< A scalar without quotes.
    std::vector<YamlNode> items;
    std::vector<Entry> entries;  ///< In the order of the file; keys are unique.
    std::shared_ptr<const YamlSource>
        origin;  ///< Place where its value was written (a var's value elsewhere); null: in `source`.

    bool is_null() const { return kind == Kind::null; }
    bool is_scalar() const { return kind == Kind::scalar; }
    bool is_list() const { return kind == Kind::list; }
    bool is_map() const { return kind == Kind::map; }
    bool is_valid() const { return kind != Kind::invalid; }
    bool is_word(std::string_view word) const { return is_scalar() && plain && text == word; }

    const std::shared_ptr<const YamlSource>& written_in() const { return origin ? origin : source; }
    /// Base of a relative path in this scalar.
    std::filesystem::path path_base() const { return written_in() ? written_in()->folder : std::filesystem::path(); }
    bool from_command_line() const { return written_in() && written_in()->command_line; }
    std::vector<std::string> keys() const;
    Entry* find(std::string_view key);
    const Entry* find(std::string_view key) const { return const_cast<YamlNode*>(this)->find(key); }
    /// Replaces the value of a key, or appends the entry with its key placed where the value is. The value in its place.
    YamlNode& set(std::string_view key, YamlNode value);
    void erase(std::string_view key);
    /// Equal for two trees that hold the same, wherever they stand.
    std::string identity() const;
    /// "a list", "a map", "nothing", "the text 'x'", "12".
    std::string summary() const;
};

struct YamlNode::Entry : YamlPlace
{
    std::string key;
    YamlNode value;
};

// They make a vector of entries, which must be complete.
inline YamlNode::YamlNode() = default;
inline YamlNode::YamlNode(Kind node_kind, const YamlPlace& place) : YamlPlace(place), kind(node_kind) {}

inline constexpr std::size_t yaml_size_limit = std::size_t{1} << 20U;  ///< bytes
/// bytes; yaml-cpp takes time that grows with the square of what one line holds.
inline constexpr std::size_t yaml_line_limit = std::size_t{1} << 16U;
inline constexpr std::size_t yaml_depth_limit = 32;
inline constexpr std::size_t yaml_node_limit = 100'000;

/// Reads one document. Anchors, aliases, tags, merge keys, duplicate keys, a second document, trailing text, open quotes, bad
/// UTF-8 and documents above the limits are problems; the rest is still returned. An empty document is a null node.
/// Sets `complete` to false when reading stopped early, so that what is missing need not be reported.
YamlNode parse_yaml(std::string_view text, std::shared_ptr<const YamlSource> source, ProblemList& problems, bool& complete);

/// The tree of a JSON-like value, as if it stood at `place` (its position, source and origin).
YamlNode yaml_from_value(const Value& value, const YamlNode& place);

/// Meaning of a scalar by the core schema of YAML 1.2 (true, false, null, decimal integers, floats; all else is text), or why it
/// is refused: 010 and 0x1f, which readers disagree about, and numbers out of range, nan and inf.
struct ResolvedScalar
{
    Value value;
    std::string refusal;  ///< Empty: `value` is good.
};
ResolvedScalar resolve_scalar(const YamlNode& scalar);

}  // namespace fresco::host
