#pragma once

/// \file What `losses: auto` stands for.

namespace fresco::optimize
{

/// Without network weights: the style's own patches, chosen with a say of the recolored camera picture.
inline constexpr const char* losses_without_weights = R"({"strokes": {"type": "loss.patch_match"}})";

/// With VGG-19 weights: Gram and content losses, each relative to its target, so that they balance alike for any scaling of the
/// network and for any layers that the file holds.
inline constexpr const char* losses_with_weights = R"({
    "style":   {"type": "loss.gram", "weight": 1, "center": true, "features": {"type": "features.vgg19", "weights": "${weights}"}},
    "content": {"type": "loss.content", "weight": 0.2, "relative": true, "features": {"type": "features.vgg19", "weights": "${weights}"}}
})";

}  // namespace fresco::optimize
