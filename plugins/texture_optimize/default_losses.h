#pragma once

/// \file What `losses: auto` stands for.

namespace fresco::optimize
{

/// Without network weights: texture statistics on a dictionary learned from the style, its own patches, and the camera's
/// gradients.
inline constexpr const char* losses_without_weights = R"({
    "style":   {"type": "loss.gram", "weight": 1, "centre": true, "features": {"type": "features.dictionary"}},
    "strokes": {"type": "loss.patch_match", "weight": 0.5},
    "content": {"type": "loss.content_gradients", "weight": 0.1}
})";

/// With VGG-19 weights: Gram and content losses, each relative to its target, so that they balance alike for any scaling of the
/// network and for any layers that the file holds.
inline constexpr const char* losses_with_weights = R"({
    "style":   {"type": "loss.gram", "weight": 1, "centre": true, "features": {"type": "features.vgg19", "weights": "${weights}"}},
    "content": {"type": "loss.content", "weight": 0.2, "relative": true, "features": {"type": "features.vgg19", "weights": "${weights}"}}
})";

}  // namespace fresco::optimize
