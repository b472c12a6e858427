#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/recordings/layout.h>

#include <cstddef>
#include <fmt/format.h>
#include <string>
#include <vector>

namespace
{

using namespace fresco::recordings;

class FramesLayout final : public Layout
{
  public:
    fresco::Marks marks() const override { return {.contains = {"frames.json"}, .before = {"*"}}; }

  private:
    Recording list(fresco::RunContext& run) override
    {
        const auto file = path() / "frames.json";
        run.reads_file(file);
        const auto read = fresco::Frames::load({path(), {}});
        listed_ = read->frames;
        Recording recording{.meshes = {path() / "mesh.ply"}};
        for (std::size_t i = 0; i < listed_.size(); ++i)
        {
            const auto& frame = listed_[i];
            RecordedView view;
            view.sequence = frame.sequence;
            view.name = frame.name;
            view.number = frame.number;
            view.color = frame.color_picture.path;
            view.depth = frame.depth_picture.path;
            view.mask = frame.mask.path;
            view.camera = frame.color.intrinsics;
            view.world_from_camera = frame.color.world_from_camera;
            view.depth_camera = frame.depth;
            for (auto* const pose : {&view.world_from_camera, &view.depth_camera->world_from_camera})
                pose->translation += read->offset_m;
            view.depth_unit_m = frame.depth_unit_m;
            view.source = fmt::format("{}: frame {}", file.string(), i);
            if (frame.color_picture.empty())
                throw fresco::Error(view.source + ": \"color_picture\" is null; expected {\"ref\": \"own:NAME\"}");
            recording.views.push_back(std::move(view));
        }
        return recording;
    }

    /// Compares the hashes that the list gives.
    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        while (listed_[next_].sequence != view.sequence || listed_[next_].name != view.name)
            ++next_;
        const auto& frame = listed_[next_];
        for (const auto* picture : {&frame.color_picture, &frame.depth_picture, &frame.mask})
            if (!picture->hash.empty() && fresco::file_hash(picture->path) != picture->hash)
                throw fresco::Error(picture->path.string() + ": its contents differ from the hash in " + view.source +
                                    "; remove \"hash\" if the new picture is right");
        return true;
    }

    std::vector<fresco::Frame> listed_;
    std::size_t next_ = 0;
};

}  // namespace

FRESCO_COMPONENT("layout.frames", FramesLayout, fresco::recordings::Layout, "Views that your own program lists in frames.json")
