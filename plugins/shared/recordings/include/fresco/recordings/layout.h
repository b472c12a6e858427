#pragma once

#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/option.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/run_context.h>
#include <fresco/stage.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file The contract of layouts: how a recorder or data set names its files, and what is in them. The stage `scan.recording`
/// reads a recording by the layout that its folder or file is for; tests of layouts do the same without the stage. Also how a
/// layout finds its files, which tells the run what the result depends on.

namespace fresco::recordings
{

/// Files of one kind: `folder`/`prefix`, digits and one of `endings`, such as color/000012.jpg.
struct NumberedFiles
{
    std::filesystem::path folder;
    std::string prefix;
    std::vector<std::string> endings;
};

/// The views whose color, depth and, where `pose` has endings, pose files have the same number, by number. Their name is the
/// color file's prefix and digits. A partner that is missing has the path where it is expected; a folder that is missing holds
/// nothing. Throws Error for two files of one kind and number, and for two spellings of a number by files of one folder and
/// prefix.
std::vector<RecordedView> numbered_views(const NumberedFiles& color, const NumberedFiles& depth, const NumberedFiles& pose,
                                         RunContext& run);

/// Says that the result depends on which names match `pattern`, a path whose last part may have '*' and '?'. Its folder need not
/// be there.
void looks_for(const std::filesystem::path& pattern, RunContext& run);

/// Clears the depth of views whose depth picture is not there: phones leave some out. Where none is there, the recording lacks a
/// folder, and all keep theirs, to be refused.
void forget_missing_depth(std::vector<RecordedView>& views);

/// The first of `candidates` that is there. Throws MissingInput that names them and says that `what` is missing.
std::filesystem::path first_file(const std::vector<std::filesystem::path>& candidates, std::string_view what, RunContext& run);

/// Doubts about the size of a mesh that should be a room's or a thing's, with the values of unit_m that would settle them; empty
/// without. `extent`: of its box, in meters, along any axes; the shortest side is a room's height. `unit_m`: meters per unit, as
/// the mesh was read.
std::string doubts_about_size(Vec3d extent, double unit_m = 1);

/// The text of a file, which the result then depends on. Throws as read_text_file does.
std::string recorded_text(const std::filesystem::path& file, RunContext& run);

/// Everything that a layout's folder or file holds.
struct Recording
{
    std::vector<RecordedView> views{};  ///< All of them, in the order in which `every` counts.
    std::string files{};                ///< The files that each view has, for errors. Empty: each view's source names them.
    std::string note{};                 ///< Ends the message "12 frames".
    /// Candidates for the mesh: the first that is there is read. A name may begin with '*'. Empty: the layout never has one.
    std::vector<std::filesystem::path> meshes{};
    bool every_of_sequence = false;  ///< `every` starts over with each sequence.
};

struct ReadRecording
{
    Frames frames;
    std::optional<Mesh> mesh;
};

struct ReadingOptions
{
    std::filesystem::path path;  ///< Folder or file.
    int every = 1;
    InputFile mesh{};         ///< In place of the layout's.
    double unit_m = 1;        ///< Meters per unit of the poses.
    double depth_unit_m = 0;  ///< Meters per step of the depth pictures; 0: the layout's.
};

/// Recordings of one layout: derive, override list() and marks(), and register with FRESCO_COMPONENT. One object reads one
/// recording, on one thread but for unpack(), and may keep what list() found. What the layout lists or reads in another way than
/// by the functions above, it says to the run.
class Layout : public Component
{
  public:
    static constexpr std::string_view component_kind = "layout";
    ~Layout() override;

  protected:
    /// The views by their files; cameras and poses where they are in common files. Throws Error, MissingInput for missing files.
    virtual Recording list(RunContext& run) = 0;
    /// Sets what is in files of the view's own, or goes by the size of its picture. Called for the chosen views, in their order,
    /// once all their files are known to be there. False where the recorder had lost track: the view is left out.
    virtual bool locate(RecordedView& view, RunContext& run);
    /// As UnpackView.
    virtual bool unpack(RecordedView& view, const std::filesystem::path& folder) const;

    const std::filesystem::path& path() const { return path_; }
    const ImageIo& codec() const { return *codec_; }

  private:
    friend ReadRecording read_recording(Layout& layout, const ReadingOptions& options, const ImageIo& images,
                                        const std::filesystem::path& folder, RunContext& run);

    std::filesystem::path path_;
    const ImageIo* codec_ = nullptr;
};

/// Reads a recording: chooses views, refuses missing files, checks pictures, cameras and poses, undoes lenses, reads the mesh.
/// Pictures that are not as recorded are written into `folder`. Throws Error and MissingInput, also what the layout throws.
ReadRecording read_recording(Layout& layout, const ReadingOptions& options, const ImageIo& images,
                             const std::filesystem::path& folder, RunContext& run);

/// The option `pixel_center`, "half" or "integer".
Choice<PixelCenter> pixel_center_option(Configurable* owner, PixelCenter value);

}  // namespace fresco::recordings
