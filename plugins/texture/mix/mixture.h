#pragma once

#include <fresco/artifact.h>
#include <fresco/image.h>

#include <string>
#include <string_view>

/// \file The second output of the stage: small pictures with which report.html mixes live.

/// The data with which the page of a run mixes both textures itself: photo + color · (colors - photo) + strokes · (painted -
/// colors). On disk: `mixture.json`, and the pictures in the folders `photo`, `colors` and `painted`, as the artifact `image`
/// keeps them.
struct Mixture : fresco::Artifact
{
    static constexpr std::string_view artifact_name = "texture_mixture";
    static constexpr int artifact_version = 2;

    std::string atlas;  ///< The mesh's atlas_id.
    double color = 1;   ///< The stage's own share; the initial position of the slider.
    double strokes = 1;
    fresco::Raster8 photo;   ///< S x S x 3, like the other two.
    fresco::Raster8 colors;  ///< The photo in the painting's colors: all of its color, none of its strokes.
    fresco::Raster8 painted;

    void save(const fresco::ArtifactFolder& folder) const override;
    static std::shared_ptr<Mixture> load(const fresco::ArtifactFolder& folder);
};
