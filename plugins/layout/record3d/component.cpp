#include "lzfse.h"
#include "metadata.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/recordings/confidence.h>
#include <fresco/recordings/layout.h>
#include <fresco/zip.h>

#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <optional>

namespace
{

namespace fs = std::filesystem;
namespace ipc = boost::interprocess;
using namespace fresco::recordings;

/// No picture or depth of a phone is larger.
constexpr std::size_t most_bytes = std::size_t{1} << 28U;

/// An .r3d file, a zip of the app's folder. Only the parts that are read take memory.
class Archive
{
  public:
    explicit Archive(const fs::path& file)
        : region_(ipc::file_mapping(file.c_str(), ipc::read_only), ipc::read_only),
          zip_({static_cast<const std::byte*>(region_.get_address()), region_.get_size()}, file.string())
    {
    }
    const fresco::ZipReader& zip() const { return zip_; }

  private:
    ipc::mapped_region region_;
    fresco::ZipReader zip_;
};

class Record3dLayout final : public Layout
{
  public:
    fresco::Marks marks() const override
    {
        return {.contains = {"metadata", "rgbd"},
                .formats = {{.name = "a recording of Record3D", .extensions = {".r3d"}, .begins = {"PK\3\4"}}}};
    }

  private:
    fresco::Option<int> min_confidence = min_confidence_option(this);

    Recording list(fresco::RunContext& run) override
    {
        Recording recording{.files = "rgbd/N.jpg and rgbd/N.depth"};
        const auto metadata = path() / "metadata";
        if (fs::is_directory(path()))
        {
            metadata_ = record3d::parse_metadata(recorded_text(metadata, run), metadata.string());
            recording.views = numbered_views({path() / "rgbd", "", {".jpg"}}, {path() / "rgbd", "", {".depth"}},
                                             {path() / "rgbd", "", {}}, run);
            looks_for(path() / "rgbd/*.conf", run);
            for (const auto& view : recording.views)
                if (const auto file = path() / name_of(view, ".conf"); fs::exists(file))
                    run.reads_file(file);
        }
        else
        {
            run.reads_file(path());
            if (fs::file_size(path()) == 0)
                throw fresco::Error(path().string() + ": the file is empty; copy it again");
            archive_.emplace(path());
            const auto text = bytes_of("metadata");
            metadata_ = record3d::parse_metadata({reinterpret_cast<const char*>(text.data()), text.size()}, metadata.string());
            for (const auto& name : archive_->zip().names())
                if (const auto number =
                        name.ends_with(".jpg") ? number_after(name.substr(0, name.size() - 4), "rgbd/") : std::nullopt)
                {
                    recording.views.emplace_back();
                    recording.views.back().name = std::to_string(*number);
                    recording.views.back().number = *number;
                }
            std::ranges::sort(recording.views, {}, &RecordedView::number);
        }
        for (auto& view : recording.views)
        {
            view.sequence = "scan";
            view.source = fmt::format("{}: pose {}", metadata.string(), view.number);
        }
        return recording;
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        const auto at = static_cast<std::size_t>(view.number);
        if (at >= metadata_.world_from_camera.size())
            throw fresco::Error(fmt::format("{}: the picture {} has none, since there are {}: copy the recording again",
                                            view.source, name_of(view, ".jpg"), metadata_.world_from_camera.size()));
        if (!metadata_.world_from_camera[at])
            return false;
        view.camera = metadata_.cameras[metadata_.cameras.size() == 1 ? 0 : at];
        view.world_from_camera = *metadata_.world_from_camera[at];
        return true;
    }

    bool unpack(RecordedView& view, const fs::path& folder) const override
    {
        const int width = metadata_.depth_width, height = metadata_.depth_height;
        const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
        const auto unpacked = [&](const std::string& name, std::size_t pixel_bytes)
        { return record3d::unpack_lzfse(bytes_of(name), pixels * pixel_bytes, (path() / name).string()); };
        const auto meters = unpacked(name_of(view, ".depth"), sizeof(float));
        fresco::Raster16 depth(width, height, 1);
        for (std::size_t i = 0; i < pixels; ++i)
        {
            float value = 0;
            std::memcpy(&value, &meters[i * sizeof value], sizeof value);
            const double steps = std::round(value / view.depth_unit_m);
            depth.values[i] = steps >= 1 && steps < 65535 ? static_cast<std::uint16_t>(steps) : std::uint16_t{0};
        }
        if (const auto name = name_of(view, ".conf"); contains(name))
        {
            const auto levels = unpacked(name, 1);
            fresco::Raster8 confidence(width, height, 1);
            std::memcpy(confidence.values.data(), levels.data(), pixels);
            remove_unsure(depth, confidence, *min_confidence, (path() / name).string());
        }
        view.depth = folder / (view.name + ".depth.png");
        fresco::write_file(view.depth, codec().encode_png(depth));
        if (archive_)
        {
            view.color = folder / (view.name + ".color.jpg");
            fresco::write_file(view.color, bytes_of(name_of(view, ".jpg")));
        }
        return true;
    }

    static std::string name_of(const RecordedView& view, const char* ending) { return "rgbd/" + view.name + ending; }
    bool contains(const std::string& name) const { return archive_ ? archive_->zip().contains(name) : fs::exists(path() / name); }
    std::vector<std::byte> bytes_of(const std::string& name) const
    {
        return archive_ ? archive_->zip().unpacked(name, most_bytes) : fresco::read_file(path() / name, most_bytes);
    }

    std::optional<Archive> archive_;
    record3d::Metadata metadata_;
};

}  // namespace

FRESCO_COMPONENT("layout.record3d", Record3dLayout, fresco::recordings::Layout,
                 "Recordings of Record3D (iPhone, iPad): the app's folder, or .r3d")
