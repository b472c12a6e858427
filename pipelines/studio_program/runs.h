#pragma once

#include <fresco/value.h>
#include <room_file.h>

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

/// \file Paintings, and the one `fresco run` at a time that makes them. A painting is a folder below STUDIO/paintings:
/// painting.json (what was asked for), painting.yaml, log.jsonl (the events of --json-log), out/ and thumb.jpg; its name is its
/// number. The folder `preview` is one, too, which the next preview replaces; its logs are log<serial>.jsonl. Whenever the
/// program is killed, paintings stay, and the one that was being made is resumed by the next Runs. A file `keep` in the folder
/// of a painting asks to end StyleMesh after the step that it is at, and to go on with what is there.

namespace fresco::studio
{

struct Painting
{
    std::string id;
    Value request;      ///< The page's request: {scan, picture, settings}.
    std::string state;  ///< running, done, failed, canceled
    bool has_thumbnail = false;
};

/// A run that was asked for; a later one has a larger serial number.
struct Started
{
    std::string id;
    int serial = 0;
};

class Runs
{
  public:
    /// `program`: fresco. `studio`: the folder for paintings and their store; created. Empty: nothing can be painted, nothing is
    /// written.
    Runs(std::filesystem::path program, std::filesystem::path studio);
    /// Ends a run that is under way; it stays resumable.
    ~Runs();
    Runs(const Runs&) = delete;
    Runs& operator=(const Runs&) = delete;

    /// Begins a painting under its id: a new number, or "preview" unless `care` is "full"; "quick" is a first look, of what is in
    /// `asked["view"]` (options of mesh.in_view), or with fewer texels and rounds than a preview has. A preview ends for whatever
    /// comes next; throws Error while another run is under way.
    Started paint(const paint::Settings& settings, const Value& asked, const std::string& care);
    /// Makes an export of a finished painting; its files are in the log export.jsonl of that painting.
    Started take(const std::string& id, const paint::Settings& settings, const std::string& kind);
    /// Ends the run under way; nothing half stays but what the store needs to go on.
    void cancel();
    /// Ends StyleMesh after the step that it is at, which becomes an option of the painting, and goes on with what is there.
    /// Throws Error saying why where that cannot be done now.
    void keep();
    /// Throws Error if there is no such painting, or while it is being made.
    void remove(const std::string& id);

    /// Newest first, without the preview.
    std::vector<Painting> paintings() const;
    std::optional<Painting> find(const std::string& id) const;
    /// {id, care, serial, request, keeps}, or null; `request` is what the page sent, `keeps`: keep() was called.
    Value running() const;
    std::filesystem::path folder_of(const std::string& id) const;

    /// The standard output of `fresco WORDS…`. Throws Error with what it printed if it fails.
    std::string answer_of(const std::vector<std::string>& words) const;

  private:
    struct Job
    {
        std::string id{};
        std::string care{};
        std::filesystem::path folder{};
        std::filesystem::path log{};
        std::vector<std::string> words{};
        std::vector<std::string> first{};  ///< Stages whose files the page shows before the long ones begin.
        bool is_painting = true;
        int serial = 0;
    };

    void refuse_if_painting() const;
    Started start(Job job);
    void work();
    void run(const Job& job);
    bool run_once(const Job& job, const std::string& until, std::ostream& log);
    void resume();
    void tidy_store() const;

    std::filesystem::path program_;
    std::filesystem::path studio_;
    std::mutex asking_;  ///< Held while a painting gets its number.
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Job> next_;
    std::optional<Job> current_;
    int serial_ = 0;
    bool canceled_ = false;
    bool keeps_ = false;
    std::int64_t steps_ = 0;  ///< StyleMesh has made these in the run under way; 0: it has not begun, or it has ended.
    bool ending_ = false;
    std::thread thread_;
};

}  // namespace fresco::studio
