#pragma once

#include "catch.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/testing.h>

#include <memory>
#include <string>

/// Rendered views, and a stage of the plugin under test that judges them.
struct JudgedViews
{
    void add(const fresco::Frame& frame, const fresco::Raster8& picture)
    {
        frames->frames.push_back(frame);
        views->names.push_back(frame.sequence + "_" + frame.name + ".png");
        views->loaded_from = views_folder.path();
        fresco::write_file(views_folder.path() / views->names.back(), stored_png::Codec().encode_png(picture));
    }

    /// The text of the file of figures.
    static std::string judge(const char* type, const fresco::Value& options, const fresco::testing::Inputs& inputs,
                             fresco::testing::TestRun& run)
    {
        const fresco::testing::TemporaryFolder out;
        fresco::testing::run_stage(FRESCO_PLUGIN_FILE, type, options, inputs, out.path(), run,
                                   {{"image_io", std::make_shared<stored_png::Codec>()}});
        const auto files = fresco::Files::load({out.path() / "figures", out.path()});
        CHECK(files->names == std::vector<std::string>{std::string(type).substr(std::string("evaluate.").size()) + ".json"});
        return fresco::read_text_file(files->loaded_from / files->names[0]);
    }

    fresco::testing::TemporaryFolder views_folder;
    std::shared_ptr<fresco::Frames> frames = std::make_shared<fresco::Frames>();
    std::shared_ptr<fresco::Files> views = std::make_shared<fresco::Files>();
};
