#pragma once

#include <fresco/dataset/manifest.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

/// The files of one view, by name relative to the folder that is being written.
struct WrittenFiles
{
    std::map<std::string, fresco::dataset::FileStamp> files;
    double sharpness = 0;  ///< fresco::sharpness at 320 x 240 of the camera picture.
};

/// Views in a folder that outlives a killed run: a view is noted once all its files are there. Thread-safe for different views.
class KeptViews
{
  public:
    /// `checkpoint`: of this result alone. Creates what it needs below it.
    explicit KeptViews(std::filesystem::path checkpoint);

    /// Where the files of all views lie until they are moved.
    std::filesystem::path folder() const { return checkpoint_ / "files"; }
    /// What an earlier run wrote of a view; nothing if there is no note, or a file that it names is gone or has another size.
    std::optional<WrittenFiles> find(std::size_t view) const;
    /// Throws Error if the note cannot be written.
    void note(std::size_t view, const WrittenFiles& written) const;

  private:
    std::filesystem::path note_of(std::size_t view) const;

    std::filesystem::path checkpoint_;
};

/// Moves a file to below another folder, whose folders it creates. Throws Error naming it.
void move_file(const std::filesystem::path& from_folder, const std::filesystem::path& to_folder, const std::string& name);
