#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/recordings/confidence.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco::recordings
{

Option<int> min_confidence_option(Configurable* owner)
{
    return {owner, "min_confidence", 2, range(0, 2), "Depth of less confidence than this counts as none"};
}

void remove_unsure(Raster16& depth, const Raster8& confidence, int least, std::string_view source)
{
    if (confidence.width != depth.width || confidence.height != depth.height)
        throw Error(fmt::format("{}: the confidence is {}x{}, and the depth picture {}x{}: copy the recording again", source,
                                confidence.width, confidence.height, depth.width, depth.height));
    const auto channels = static_cast<std::size_t>(confidence.channels);
    for (std::size_t i = 0; i < depth.values.size(); ++i)
        if (confidence.values[channels * i] < least)
            depth.values[i] = 0;
}

bool write_sure_depth(RecordedView& view, const std::filesystem::path& confidence, int least, const ImageIo& images,
                      const std::filesystem::path& folder)
{
    if (view.depth.empty() || !std::filesystem::exists(confidence))
        return false;
    const auto levels = images.read_rgb(confidence);
    if (std::ranges::none_of(levels.values, [&](auto level) { return level < least; }))
        return false;
    auto depth = images.read_depth(view.depth);
    remove_unsure(depth, levels, least, confidence.string());
    view.depth = folder / (view.name + ".depth.png");
    write_file(view.depth, images.encode_png(depth));
    return true;
}

}  // namespace fresco::recordings
