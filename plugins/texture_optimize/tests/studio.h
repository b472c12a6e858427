#pragma once

#include "fakes.h"

#include "catch.h"

#include <fresco/files_io.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fakes
{

inline Raster8 style_picture()
{
    Raster8 picture(96, 72, 3);
    for (std::size_t i = 0; i < picture.values.size(); ++i)
        picture.values[i] = static_cast<std::uint8_t>(40 + (i * 37) % 150);
    return picture;
}

/// Paints the wall by the built plugin, with fake losses and the real texture and rule.
struct Studio
{
    testing::TemporaryFolder folder;
    Wall wall;
    int runs = 0;

    explicit Studio(std::size_t views = 6, const std::vector<int>& heights = {30}) : wall(folder.path() / "wall", views, heights)
    {
    }

    static Value options(const Value& losses, Value::Map more)
    {
        Value options = Value::Map{{"size_px", 64},
                                   {"repeats_count", 3},
                                   {"device", "cpu"},
                                   {"losses", losses},
                                   {"texture", Value::Map{{"type", "texture.laplacian"}}},
                                   {"optimizer", Value::Map{{"type", "optimizer.adam"}, {"mode", "visible"}, {"beta2", 0.99}}}};
        for (auto& [name, value] : more)
            options.set(name, value);
        return options;
    }

    /// Runs the built plugin; the texture's folder.
    std::filesystem::path paint(testing::TestRun& run, const Value& options, const std::shared_ptr<Texture>& start = nullptr)
    {
        testing::TestFactory factory;
        factory.add("texture.laplacian",
                    [] { return testing::make_from_plugin<Component>(FRESCO_PLUGIN_texture_laplacian, "texture.laplacian"); });
        factory.add("optimizer.adam",
                    [] { return testing::make_from_plugin<Component>(FRESCO_PLUGIN_optimizer_adam, "optimizer.adam"); });
        factory.add("features.half", [] { return std::make_shared<HalfNetwork>(); });
        factory.add("camera", [] { return std::make_shared<CameraLoss>(); });
        factory.add("mean", [] { return std::make_shared<MeanLoss>(); });
        factory.add("fragile", [] { return std::make_shared<FragileLoss>(); });
        factory.add("asking", [] { return std::make_shared<AskingLoss>(0); });
        factory.add("breaking", [] { return std::make_shared<AskingLoss>(9); });
        factory.add("exploding", [] { return std::make_shared<ExplodingLoss>(); });
        const auto stage = testing::make_from_plugin<Stage>(FRESCO_PLUGIN_FILE, "texture.optimize");
        const auto out = folder.path() / ("run" + std::to_string(runs++));
        testing::Inputs inputs{{"uvmaps", wall.maps},
                               {"frames", std::make_shared<Frames>(wall.frames)},
                               {"style", std::make_shared<Image>(style_picture())}};
        if (start)
            inputs["start"] = start;
        testing::run_stage(*stage, options, inputs, out, run, factory);
        return out / "texture";
    }
};

inline std::vector<std::vector<std::byte>> bytes_in(const std::filesystem::path& texture)
{
    std::vector<std::vector<std::byte>> result;
    for (const char* name : {"layer_0.npy", "layer_1.npy", "layer_2.npy", "layer_3.npy", "seen.npy", "texture.json"})
        result.push_back(read_file(texture / name));
    return result;
}

inline const Value camera_loss = Value::Map{{"camera", Value::Map{{"type", "camera"}}}};
inline const Value mean_losses =
    Value::Map{{"a", Value::Map{{"type", "mean"}, {"features", Value::Map{{"type", "features.half"}}}}},
               {"b", Value::Map{{"type", "camera"}, {"weight", 0.3}}}};

}  // namespace fakes
