#pragma once

#include "reader_run.h"
#include "recording_checks.h"

#include <vector>

/// \file Damage to the files of a recording, and what its reader makes of them when it runs as the host runs it.

namespace fresco::testing
{

/// A file to be damaged, and how many of 200 cuts and 500 flips its reader is known to find at least.
struct DamagedFile
{
    std::filesystem::path file;
    int cuts_refused = 200;
    int flips_refused = 0;
};

/// Damages each of `files` in turn as damage_file does, and runs the reader `type` each time. It must throw fresco::Error, or
/// give cameras that can be used, pictures that can be loaded and a mesh that is valid; of a file that is cut, nothing but frames
/// of the whole recording, and its mesh. Parameters as run_reader's.
inline void check_damage(const std::filesystem::path& plugin, const std::string& type, const std::filesystem::path& path,
                         const RawImages& images, const std::filesystem::path& out, const std::vector<DamagedFile>& files,
                         const Value& options = Value::Map{})
{
    const auto read = [&]
    {
        TestRun run(1);
        return run_reader_unsaved(plugin, type, path, images, out, run, options);
    };
    const auto whole = read();
    REQUIRE_FALSE(whole.frames->frames.empty());
    for (const DamagedFile& damaged : files)
    {
        INFO(damaged.file);
        const auto counts = damage_file(damaged.file,
                                        [&](bool cut)
                                        {
                                            const auto found = read();
                                            check_usable(*found.frames);
                                            for (const Frame& frame : found.frames->frames)
                                            {
                                                load_color(frame, &images);
                                                if (!frame.depth_picture.empty())
                                                    load_depth(frame, &images);
                                            }
                                            if (found.mesh)
                                                check_mesh(*found.mesh, "the mesh");
                                            if (!cut)
                                                return;
                                            check_subset(*found.frames, *whole.frames);
                                            if (whole.mesh)
                                                REQUIRE(found.mesh->positions == whole.mesh->positions);
                                        });
        CHECK(counts.cuts_refused >= damaged.cuts_refused);
        CHECK(counts.flips_refused >= damaged.flips_refused);
    }
}

}  // namespace fresco::testing
