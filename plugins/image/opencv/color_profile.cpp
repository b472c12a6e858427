#include "color_profile.h"

#include <fresco/error.h>

#include <fmt/format.h>
#include <lcms2.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

namespace image_opencv
{
namespace
{

[[noreturn]] void refuse(std::string_view source, const std::string& what)
{
    throw fresco::Error(fmt::format("{}: {}; convert the picture to sRGB", source, what));
}

using Context = std::unique_ptr<std::remove_pointer_t<cmsContext>, Closing<cmsDeleteContext>>;
using Profile = std::unique_ptr<void, Closing<cmsCloseProfile>>;
using Transform = std::unique_ptr<void, Closing<cmsDeleteTransform>>;
using Curve = std::unique_ptr<cmsToneCurve, Closing<cmsFreeToneCurve>>;

/// lcms2's number for pixels of T.
template <class T>
cmsUInt32Number pixels_of(int space, int channels, bool with_alpha)
{
    return static_cast<cmsUInt32Number>(COLORSPACE_SH(space) | CHANNELS_SH(channels) | BYTES_SH(sizeof(T)) |
                                        EXTRA_SH(with_alpha));
}

/// From one profile to another, for rasters of T.
template <class T>
class Conversion
{
  public:
    Conversion(cmsContext context, cmsHPROFILE from, cmsHPROFILE to, bool is_gray, std::string_view source)
        : context_(context), from_(from), to_(to), source_(source), is_gray_(is_gray)
    {
    }

    fresco::Raster<T> operator()(fresco::Raster<T> picture) const
    {
        if (is_gray_)
            return of_gray(std::move(picture));
        if (is_identity())
            return picture;
        if (picture.channels == 1)
            picture = in_colors(picture);
        const Transform transform = transform_of(pixels_of<T>(PT_RGB, 3, picture.channels == 4));
        for (int y = 0; y < picture.height; ++y)
        {
            T* const row = &picture.values[picture.index(0, y)];
            cmsDoTransform(transform.get(), row, row, static_cast<cmsUInt32Number>(picture.width));
        }
        return picture;
    }

  private:
    static constexpr int greatest = std::numeric_limits<T>::max();

    Transform transform_of(cmsUInt32Number pixels) const
    {
        const bool keeps_alpha = T_EXTRA(pixels) != 0;
        // An optimized transform of 16 bits is a coarse table, off by 14 of 255.
        const cmsUInt32Number exact = sizeof(T) > 1 ? cmsFLAGS_NOOPTIMIZE : 0U;
        const cmsUInt32Number flags = cmsFLAGS_BLACKPOINTCOMPENSATION | exact | (keeps_alpha ? cmsFLAGS_COPY_ALPHA : 0U);
        Transform transform(cmsCreateTransformTHR(context_, from_, pixels, to_, pixels_of<T>(PT_RGB, 3, keeps_alpha),
                                                  INTENT_RELATIVE_COLORIMETRIC, flags));
        if (transform == nullptr)
            refuse(source_, "Little CMS cannot convert from its color profile, which may be damaged");
        return transform;
    }

    /// A profile of gray has no hue: a table of all grays is enough, and the channels stay.
    fresco::Raster<T> of_gray(fresco::Raster<T> picture) const
    {
        std::vector<T> grays(std::size_t{greatest} + 1);
        for (std::size_t i = 0; i < grays.size(); ++i)
            grays[i] = static_cast<T>(i);
        std::vector<T> colors(grays.size() * 3);
        cmsDoTransform(transform_of(pixels_of<T>(PT_GRAY, 1, false)).get(), grays.data(), colors.data(),
                       static_cast<cmsUInt32Number>(grays.size()));
        const auto channels = static_cast<std::size_t>(picture.channels);
        for (std::size_t i = 0; i < picture.values.size(); ++i)
            if (channels != 4 || i % 4 != 3)
                picture.values[i] = colors[std::size_t{picture.values[i]} * 3 + 1];
        return picture;
    }

    static fresco::Raster<T> in_colors(const fresco::Raster<T>& grays)
    {
        fresco::Raster<T> result(grays.width, grays.height, 3);
        for (std::size_t i = 0; i < result.values.size(); ++i)
            result.values[i] = grays.values[i / 3];
        return result;
    }

    /// Many programs write a profile of sRGB itself; rounding must not change such a picture.
    bool is_identity() const
    {
        constexpr int steps = 9;
        std::vector<T> colors;
        for (int i = 0; i < steps * steps * steps; ++i)
            for (const int part : {i / (steps * steps), i / steps % steps, i % steps})
                colors.push_back(static_cast<T>(part * greatest / (steps - 1)));
        std::vector<T> converted(colors.size());
        cmsDoTransform(transform_of(pixels_of<T>(PT_RGB, 3, false)).get(), colors.data(), converted.data(),
                       static_cast<cmsUInt32Number>(colors.size() / 3));
        return std::ranges::equal(colors, converted, [](int a, int b) { return std::abs(a - b) <= greatest / 255; });
    }

    cmsContext context_;
    cmsHPROFILE from_;
    cmsHPROFILE to_;
    std::string_view source_;
    bool is_gray_;
};

}  // namespace

DecodedPicture in_srgb(DecodedPicture picture, std::span<const std::byte> icc, std::string_view source)
{
    if (icc.empty())
        return picture;
    const Context context(cmsCreateContext(nullptr, nullptr));
    const Profile from(cmsOpenProfileFromMemTHR(context.get(), icc.data(), static_cast<cmsUInt32Number>(icc.size())));
    if (from == nullptr)
        refuse(source, "its color profile is damaged");
    const cmsColorSpaceSignature space = cmsGetColorSpace(from.get());
    if (space == cmsSigCmykData)
        return picture;
    if (space != cmsSigRgbData && space != cmsSigGrayData)
        refuse(source, "its color profile is neither of RGB nor of gray");
    const Profile to(cmsCreate_sRGBProfileTHR(context.get()));
    return std::visit(
        [&]<class T>(fresco::Raster<T>& raster) -> DecodedPicture
        { return Conversion<T>(context.get(), from.get(), to.get(), space == cmsSigGrayData, source)(std::move(raster)); },
        picture);
}

std::vector<std::byte> icc_of_primaries(const std::array<float, 8>& xy, double gamma, std::string_view source)
{
    const Context context(cmsCreateContext(nullptr, nullptr));
    // IEC 61966-2-1.
    const std::array<double, 5> srgb{2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    const Curve curve(gamma == 0 ? cmsBuildParametricToneCurve(context.get(), 4, srgb.data())
                                 : cmsBuildGamma(context.get(), gamma));
    const cmsCIExyY white{xy[6], xy[7], 1};
    const cmsCIExyYTRIPLE primaries{{xy[0], xy[1], 1}, {xy[2], xy[3], 1}, {xy[4], xy[5], 1}};
    std::array<cmsToneCurve*, 3> curves{curve.get(), curve.get(), curve.get()};
    const Profile profile(cmsCreateRGBProfileTHR(context.get(), &white, &primaries, curves.data()));
    cmsUInt32Number size = 0;
    if (profile == nullptr || !cmsSaveProfileToMem(profile.get(), nullptr, &size))
        refuse(source, "its primary colors span no colors");
    std::vector<std::byte> icc(size);
    if (!cmsSaveProfileToMem(profile.get(), icc.data(), &size))
        refuse(source, "its primary colors make no profile");
    return icc;
}

}  // namespace image_opencv
