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
#include <variant>
#include <vector>

/// \file The base of stages that read recordings, and how such a stage finds its files. What the result depends on is said to the
/// run.

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

/// The file that an option gives, else the first of `candidates` that is there. Throws MissingInput that names the candidates and
/// the option, and says that `what` is missing.
std::filesystem::path first_file(const InputFile& given, const std::vector<std::filesystem::path>& candidates,
                                 std::string_view what, std::string_view option, RunContext& run);

/// The text of a file, which the result then depends on. Throws as read_text_file does.
std::string recorded_text(const std::filesystem::path& file, RunContext& run);

/// What a layout's folder, or file, holds.
struct Recording
{
    std::vector<RecordedView> views{};  ///< All of them, in the order in which `every` counts.
    std::string files{};                ///< The files that each view has, for errors. Empty: each view's source names them.
    std::string note{};                 ///< Ends the message "12 frames".
    bool every_of_sequence = false;     ///< `every` starts over with each sequence.
};

/// Help of the options and the output that each reader has.
struct RecordingHelp
{
    std::string path;
    std::string frames;
    std::string every = "Use every n-th frame";
    FolderWith folder{};      ///< Of `path` where it is a folder.
    Extensions extensions{};  ///< Of `path` where it is a file; empty: a folder.
};

/// Reads recorded views of one layout: derive, override list(), and register with FRESCO_STAGE. The base has the options `path`,
/// `every` and `images` and the output `frames`. It chooses views, refuses missing files, checks pictures, cameras and poses,
/// undoes lenses, and says what the result depends on: the chosen views' files, and those of first_file and recorded_text. What
/// the layout lists or reads in another way, it says itself.
class RecordingStage : public Stage
{
  protected:
    explicit RecordingStage(const RecordingHelp& help);

    /// The views by their files; cameras and poses where they are in common files. Throws Error, MissingInput for missing files.
    virtual Recording list(RunContext& run) = 0;
    /// Sets what is in files of the view's own, or goes by the size of its picture. Called for the chosen views, in their order,
    /// once all their files are known to be there. False where the recorder had lost track: the view is left out.
    virtual bool locate(RecordedView& view, RunContext& run);
    /// As UnpackView.
    virtual bool unpack(RecordedView& view, const std::filesystem::path& folder) const;

    const std::filesystem::path& path() const;
    const ImageIo& codec() const { return *images; }

  private:
    void run(RunContext& run) final;

    std::variant<Option<InputFolder>, Option<InputFile>> path_;
    Option<int> every;
    Slot<ImageIo> images{this, "Reads and writes pictures"};
    Output<Frames> frames;
};

/// The option `mesh` and the optional output of that name, for a reader whose layout has a mesh: a member of it.
class RecordedMesh
{
  public:
    RecordedMesh(Configurable* owner, std::string option_help, std::string output_help);

    const InputFile& given() const { return *file_; }
    /// Reads the mesh that the option gives, else the first of `candidates` that is there, if any.
    void read(const std::vector<std::filesystem::path>& candidates, RunContext& run);
    /// Warns that the mesh is missing: the output stays empty.
    void leave_out(const std::string& expected, RunContext& run);
    RecordedMesh& operator=(Mesh surface);

  private:
    Option<InputFile> file_;
    Output<Mesh> mesh_;
};

/// The option `depth_unit_m`.
Option<double> depth_unit_option(Configurable* owner, double unit_m = 0.001);

/// The option `pixel_center`, "half" or "integer".
class PixelCenterOption
{
  public:
    PixelCenterOption(Configurable* owner, const std::string& word);
    PixelCenter operator*() const { return *word_ == "half" ? PixelCenter::half : PixelCenter::integer; }

  private:
    Option<std::string> word_;
};

}  // namespace fresco::recordings
