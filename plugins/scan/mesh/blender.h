#pragma once

#include <fresco/option_declaration.h>
#include <fresco/run_context.h>

#include <filesystem>

/// \file Models in formats that only Blender reads: it runs as a program of its own and writes a GLB, which read_file_model()
/// reads.

namespace scan_mesh
{

/// Formats that some version of Blender reads and read_file_model() does not. Which of them the installed one reads shows when it
/// is asked.
fresco::FileFormat blender_format();

/// Lets the Blender in PATH convert a model. Returns a GLB in the run's scratch folder, in Blender's axes, z up, and unit, the
/// meter where the file names its own. The result depends on the program and on the files that the model names. Throws
/// MissingInput if Blender is missing or has no importer for the extension; Error with its last lines if it fails, or needs too
/// much time or memory.
std::filesystem::path glb_by_blender(const std::filesystem::path& model, fresco::RunContext& run);

}  // namespace scan_mesh
