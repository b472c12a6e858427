#pragma once

#include <fresco/artifact.h>
#include <fresco/dataset/manifest.h>
#include <fresco/frames.h>

#include <cstddef>
#include <filesystem>

/// A dataset's folder, and the artifacts' folders that its views go to.
struct ViewFolders
{
    std::filesystem::path dataset;
    fresco::ArtifactFolder uvmaps;
    std::filesystem::path frames;
};

struct ReadView
{
    fresco::Frame frame;
    int uv_bits = 0;  ///< The most of its maps.
};

/// Copies one view: its uv maps to `uvmaps`, with texcoords as float32, and its pictures at full size to `frames`, whose frame is
/// returned. All files of the view are checked, those that are not copied too. Holds one height at a time. Thread-safe for
/// different views. Throws Error naming the file if it is missing, not as listed, of another shape or type, or holds values out
/// of range.
ReadView read_view(const fresco::dataset::Manifest& manifest, std::size_t view, const ViewFolders& folders);
