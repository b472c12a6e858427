#include <fresco/error.h>
#include <fresco/recordings/confidence.h>

#include <fmt/format.h>

namespace fresco::recordings
{

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

}  // namespace fresco::recordings
