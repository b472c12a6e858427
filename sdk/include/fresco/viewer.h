#pragma once

#include <fresco/artifact.h>
#include <fresco/component.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// \file How artifacts are shown on the page of a run: a component beside each type that has something to show.

namespace fresco
{

/// Scripts that the page needs once to draw entries of some kind.
struct PageScripts
{
    std::string_view css{};
    std::string_view library{};  ///< JavaScript as its authors wrote it, before all other.
    std::string_view js{};       ///< Strict.
};

/// Entry of the page for one artifact, and the page's wishes. Used by one thread.
struct PageEntry
{
    /// Show what belongs to these: names of pictures that stages made of this artifact and the page shows ("views/s_7.png").
    /// An artifact that holds files shows exactly those. Empty: the viewer chooses.
    std::vector<std::string> names{};
    bool last = true;                         ///< No later stage makes this type of artifact; show large things only then.
    std::size_t most_pictures = 12;           ///< At most so many.
    int longest_px = 720;                     ///< Longer side of a picture on the page.
    std::uintmax_t video_bytes = 24'000'000;  ///< Bytes of the page that are left for videos.

    Value value{Value::Map{}};  ///< {pictures: [{name, uri, …}], notes: [text], …}: sdk/docs/report.md.
    const PageScripts* scripts =
        nullptr;  ///< Scripts that draw it, if the page itself does not; they live as long as the library.

    /// Adds to one of the lists of `value`.
    void append(std::string_view list, Value entry);
    /// Says what the page lacks.
    void note(const std::string& text) { append("notes", text); }
};

/// Shows artifacts of one type. The host picks it by the type, and calls it in a process of its own, after the run.
class Viewer : public Component
{
  public:
    static constexpr std::string_view component_kind = "viewer";
    ~Viewer() override;
    const ArtifactType& type() const { return type_; }
    /// For an artifact that holds files: extensions of its pictures, lower case, with the dot (".png").
    virtual std::vector<std::string> extensions() const { return {}; }
    /// Adds what there is to see. Throws Error for what cannot be shown: the page says so, and keeps what was given before.
    virtual void show(const Artifact& artifact, PageEntry& entry) const = 0;

  protected:
    /// `type`: RegisteredArtifact<T>::type.
    explicit Viewer(const ArtifactType& type) : type_(type) {}

  private:
    const ArtifactType& type_;
};

/// JSON that may stand in a script element: no "<" in it could end that.
std::string script_json(const Value& value);

}  // namespace fresco
