#pragma once

#include <fresco/run_context.h>

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// \file Files that a recording or model lists under names that are not quite theirs: written on Windows or another machine, by a
/// program that ran elsewhere, or converted since.

namespace fresco::recordings
{

/// A file as a recording names it.
struct ListedFile
{
    std::filesystem::path folder;         ///< Folder that the name is relative to.
    std::string name;                     ///< As listed, with '/' or '\'.
    std::filesystem::path* to = nullptr;  ///< Place for the path; not owned.
    bool any_ending = true;               ///< A picture may have another ending.
};

/// Gets each path, its last part perhaps with '?', whose presence decides what is found.
using LooksFor = std::function<void(const std::filesystem::path& pattern)>;

/// Sets the paths of all files: folder/name where that is there. Where it is not, the first of these rules that finds a file
/// holds for all that are missing: '/' for '\'; another ending of pictures; another case; the last parts of the path below
/// `recording` or the folder, in any case. Returns a message about how many were found so; empty where each was where it is
/// listed, or none was found. What no rule finds has the path folder/name. Throws Error if a rule finds two files for a name.
std::string find_listed_files(const std::vector<ListedFile>& files, const std::filesystem::path& recording,
                              const LooksFor& looks_for);
/// find_listed_files for a stage: the result depends on what was looked for, and the message goes to the run.
void find_listed_files(const std::vector<ListedFile>& files, const std::filesystem::path& recording, RunContext& run);

/// Notes of a reader: what it looked for, and what the user must know of it.
struct FileNotes
{
    std::vector<std::filesystem::path> looked_for;  ///< Paths whose presence counts; '?' stands for any character.
    std::vector<std::string> messages;
};

/// The folder of a model, for finding the files that the model names. Never leads outside of the folder.
class ModelFolder
{
  public:
    /// \param notes Receives what is looked for; must outlive this.
    ModelFolder(const std::filesystem::path& model, FileNotes& notes);

    /// The file of this name below `folder`, which is in the model's: the name itself, or what stands for it by the rules of
    /// find_listed_files. Of a name that leads out, such as C:\room\a.png or ../a.png, the last parts count. `place`
    /// is the position of the name ("room.obj:3: mtllib") and begins each message; `way_out` ends the one about a missing file.
    /// Throws MissingInput if there is no such file; Error if two could be meant, and for links that lead outside.
    std::filesystem::path find(std::string_view name, std::string_view place, std::string_view way_out = {},
                               std::filesystem::path folder = {}) const;

    /// Whether find() would succeed.
    bool has(std::string_view name) const;

  private:
    std::filesystem::path folder_;
    FileNotes& notes_;
};

/// Whether a system put the file there, not the recorder: "._a.png" and .DS_Store of macOS, Thumbs.db and desktop.ini of Windows,
/// @eaDir of network disks.
bool is_system_file(const std::filesystem::path& file);

}  // namespace fresco::recordings
