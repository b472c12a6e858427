#include "report/report_media.h"

#include "report/report_figures.h"
#include "report/report_room.h"

#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/html.h>
#include <fresco/image.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr std::size_t most_views = 12;
constexpr std::size_t most_pictures = 24;
constexpr int view_px = 720;
constexpr int picture_px = 640;
constexpr int atlas_px = 1024;
constexpr int quality = 82;
constexpr std::uintmax_t most_video_bytes = 8'000'000;
constexpr std::uintmax_t most_videos_bytes = 24'000'000;  // Of all.

/// A place among the results: where an artifact lies, and of which stage.
struct Stored
{
    const ReportStage* stage = nullptr;
    ArtifactFolder folder;
};

class Collector
{
  public:
    Collector(const ReportModel& model, const ImageIo& images) : model_(model), images_(images), store_(model.store) {}

    ReportMedia collect()
    {
        attempt("The views", [&] { take_views(); });
        attempt("The room", [&] { take_room(); });
        take_pictures();
        return std::move(media_);
    }

  private:
    template <class Act>
    void attempt(const std::string& what, Act act)
    {
        try
        {
            act();
        }
        catch (const Error& error)
        {
            media_.notes.push_back(what + ": " + error.what());
        }
    }

    const ReportStage* find(const std::string& name) const
    {
        const auto found = std::ranges::find(model_.stages, name, &ReportStage::name);
        return found == model_.stages.end() ? nullptr : &*found;
    }

    std::optional<Stored> stored(const ReportStage& stage, const std::string& output) const
    {
        if (stage.object.empty() || !store_.present(stage.object))
            return std::nullopt;
        return Stored{&stage, {store_.object(stage.object) / output, store_.root()}};
    }

    /// The last result of this kind in the pipeline's order.
    std::optional<Stored> last_of(std::string_view artifact) const
    {
        for (auto stage = model_.stages.rbegin(); stage != model_.stages.rend(); ++stage)
            for (const ReportOutput& output : stage->outputs)
                if (output.artifact == artifact)
                    if (auto found = stored(*stage, output.name))
                        return found;
        return std::nullopt;
    }

    /// The frames that a stage was given, where that is so.
    std::optional<Stored> frames_given_to(const ReportStage& stage) const
    {
        for (const ReportInput& input : stage.inputs)
            if (input.artifact == Frames::artifact_name)
                if (const ReportStage* producer = find(input.from_stage); producer != nullptr)
                    return stored(*producer, input.from_port);
        return std::nullopt;
    }

    std::string jpeg(const Raster8& picture, int longest) const
    {
        const double scale = std::min(1.0, static_cast<double>(longest) / std::max(picture.width, picture.height));
        const auto side = [&](int px) { return std::max(1, static_cast<int>(std::lround(px * scale))); };
        return data_uri(
            "image/jpeg",
            images_.encode_jpeg(scale < 1 ? resized(picture, side(picture.width), side(picture.height)) : picture, quality));
    }

    static bool is_picture(const fs::path& file)
    {
        const std::string extension = file.extension().string();
        return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
    }

    /// Pictures that a stage wrote under the names of the frames that it was given, <sequence>_<frame>.png.
    struct RenderedFrames
    {
        std::shared_ptr<Frames> frames;
        std::vector<std::pair<std::size_t, const ReportFile*>> pairs;
    };
    RenderedFrames rendered_frames(const ReportStage& stage) const
    {
        RenderedFrames result;
        std::map<std::string, const ReportFile*> files;
        for (const ReportFile& file : model_.files)
            if (file.stage == stage.name && is_picture(file.name))
                files.emplace(fs::path(file.name).stem().string(), &file);
        const auto given = files.empty() ? std::nullopt : frames_given_to(stage);
        if (!given)
            return result;
        result.frames = Frames::load(given->folder);
        for (std::size_t i = 0; i < result.frames->frames.size(); ++i)
        {
            const Frame& frame = result.frames->frames[i];
            if (const auto file = files.find(frame.sequence + "_" + frame.name);
                file != files.end() && !frame.color_picture.empty())
                result.pairs.emplace_back(i, file->second);
        }
        return result;
    }

    void take_views()
    {
        RenderedFrames best;
        for (const ReportStage& stage : model_.stages)
            if (RenderedFrames found = rendered_frames(stage); found.pairs.size() > best.pairs.size())
            {
                best = std::move(found);
                views_stage_ = stage.name;
            }
        if (!best.pairs.empty())
            frames_ = best.frames;
        for (const std::size_t i : evenly_spread(best.pairs.size(), most_views))
        {
            const auto& [index, file] = best.pairs[i];
            const Frame& frame = best.frames->frames[index];
            media_.views.push_back({frame.sequence + "/" + frame.name, jpeg(load_color(frame, &images_), view_px),
                                    jpeg(images_.read_rgb(model_.out / file->name), view_px), pose_value(frame.color)});
        }
    }

    void take_room()
    {
        const auto room = last_of(TexturedMesh::artifact_name);
        if (!room)
            return;
        if (frames_ == nullptr)
            if (const auto frames = last_of(Frames::artifact_name))
                frames_ = Frames::load(frames->folder);
        const auto mesh = TexturedMesh::load(room->folder);
        media_.atlas.push_back({room->stage->name + ", " + figure_text(mesh->image.pixels.width) + " × " +
                                    figure_text(mesh->image.pixels.height) + " texels",
                                jpeg(mesh->image.pixels, atlas_px), false});
        media_.room.push_back(report_room(room->stage->name, *mesh, frames_.get(), images_));
    }

    void take_pictures()
    {
        std::map<std::string, std::vector<const ReportFile*>> by_stage;
        for (const ReportFile& file : model_.files)
            if (file.stage != views_stage_ && is_picture(file.name))
                by_stage[file.stage].push_back(&file);
        const std::size_t each = by_stage.empty() ? 0 : std::max<std::size_t>(1, most_pictures / by_stage.size());
        for (const auto& [stage, files] : by_stage)
            for (const std::size_t i : evenly_spread(files.size(), each))
                attempt(files[i]->name,
                        [&, file = files[i]] {
                            media_.pictures.push_back(
                                {file->name, jpeg(images_.read_rgb(model_.out / file->name), picture_px), false});
                        });
        for (const ReportFile& file : model_.files)
            if (const std::string kind = fs::path(file.name).extension().string(); kind == ".mp4" || kind == ".webm")
                attempt(file.name, [&] { take_video(file, "video/" + kind.substr(1)); });
    }

    void take_video(const ReportFile& file, const std::string& media_type)
    {
        if (file.bytes > most_video_bytes)
            throw Error("a video of " + bytes_text(static_cast<double>(file.bytes)) + " is not put into a page; open the file");
        if (video_bytes_ + file.bytes > most_videos_bytes)
            throw Error("the page has videos of " + bytes_text(static_cast<double>(video_bytes_)) + " already; open the file");
        media_.pictures.push_back({file.name, data_uri(media_type, read_file(model_.out / file.name)), true});
        video_bytes_ += file.bytes;
    }

    const ReportModel& model_;
    const ImageIo& images_;
    Store store_;
    ReportMedia media_;
    std::shared_ptr<Frames> frames_;
    std::string views_stage_;
    std::uintmax_t video_bytes_ = 0;
};

}  // namespace

std::vector<std::size_t> evenly_spread(std::size_t size, std::size_t count)
{
    std::vector<std::size_t> chosen;
    const std::size_t taken = std::min(size, count);
    for (std::size_t i = 0; i < taken; ++i)
        chosen.push_back(i * size / taken);
    return chosen;
}

ReportMedia report_media(const ReportModel& model, const ImageIo& images)
{
    return Collector(model, images).collect();
}

}  // namespace fresco::host
