#pragma once

#include <fresco/artifact.h>
#include <fresco/image.h>
#include <fresco/math.h>

#include <optional>
#include <string>

namespace fresco
{

/// Where in a picture each texel of a painted texture comes from, so that a finer texture or another channel can be copied
/// without a new search. On disk: `source_map.json` and `places.npy` (uint16 S x S x 3).
struct SourceMap : Artifact
{
    static constexpr std::string_view artifact_name = "source_map";
    static constexpr int artifact_version = 1;

    /// A texel's place in the picture.
    struct Place
    {
        Vec2f at;  ///< Pixels of the picture, (0, 0) at its upper left corner, pixel centers at +0.5.
        float angle =
            0;  ///< Radians: one texel to the right in the texture is pixels_per_texel (cos, sin) in the picture, y down.
    };

    std::string atlas;           ///< The mesh's atlas_id; empty: unknown.
    int picture_width = 0;       ///< Of the whole picture …
    int picture_height = 0;      ///< … that places are in.
    float pixels_per_texel = 1;  ///< The picture's pixels along a texel's side.
    Raster16 places;             ///< See set_place. Zeros are a place: fill with `none` before use.

    static constexpr std::uint16_t none = 0xffff;  ///< All three values of a texel that comes from nowhere.

    ~SourceMap() override;
    SourceMap() = default;
    SourceMap(const SourceMap&) = default;
    SourceMap(SourceMap&&) = default;
    SourceMap& operator=(const SourceMap&) = default;
    SourceMap& operator=(SourceMap&&) = default;

    int size_px() const { return places.width; }
    /// Nothing where the texel comes from nowhere.
    std::optional<Place> place(int x, int y) const;
    /// Rounds to 1/65534 of the picture's sides and of a turn; places outside of the picture are clamped to it.
    void set_place(int x, int y, const Place& place);

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<SourceMap> load(const ArtifactFolder& folder);
};

}  // namespace fresco
