#include "components.h"

#include "scene.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace bench
{
namespace
{

std::shared_ptr<fresco::Component> from_plugin(const std::string& type)
{
    std::string file = type;
    file[file.find('.')] = '_';
    return fresco::testing::make_from_plugin<fresco::Component>(std::filesystem::path(FRESCO_PLUGIN_FOLDER) / (file + ".so"),
                                                                type);
}

/// Deterministic, roughly normal.
torch::Tensor noise(const std::vector<std::int64_t>& shape, double deviation, std::uint64_t seed)
{
    auto values = at::empty(shape, at::kFloat);
    auto* value = values.data_ptr<float>();
    for (std::int64_t i = 0; i < values.numel(); ++i)
    {
        double sum = 0;
        for (int k = 0; k < 3; ++k)
        {
            seed = seed * 6364136223846793005U + 1442695040888963407U;
            sum += static_cast<double>(seed >> 33U) / 2147483648.0 - 0.5;
        }
        value[i] = static_cast<float>(2 * sum * deviation);
    }
    return values;
}

}  // namespace

Components::Components()
{
    for (const char* type :
         {"loss.gram", "loss.content", "loss.patch_match", "features.vgg19", "texture.laplacian", "optimizer.adam"})
        factory_.add(type, [type] { return from_plugin(type); });
}

std::vector<ConvolutionShape> vgg19_shapes(std::string_view last)
{
    constexpr std::array shapes{ConvolutionShape{"conv1_1", 64, 3, 1},    ConvolutionShape{"conv1_2", 64, 64, 1},
                                ConvolutionShape{"conv2_1", 128, 64, 2},  ConvolutionShape{"conv2_2", 128, 128, 2},
                                ConvolutionShape{"conv3_1", 256, 128, 4}, ConvolutionShape{"conv3_2", 256, 256, 4},
                                ConvolutionShape{"conv3_3", 256, 256, 4}, ConvolutionShape{"conv3_4", 256, 256, 4},
                                ConvolutionShape{"conv4_1", 512, 256, 8}, ConvolutionShape{"conv4_2", 512, 512, 8},
                                ConvolutionShape{"conv4_3", 512, 512, 8}, ConvolutionShape{"conv4_4", 512, 512, 8},
                                ConvolutionShape{"conv5_1", 512, 512, 16}};
    const auto end = std::find_if(shapes.begin(), shapes.end(), [&](const auto& shape) { return shape.name == last; });
    return {shapes.begin(), end == shapes.end() ? end : end + 1};
}

void write_random_vgg19(const std::filesystem::path& file, std::string_view last)
{
    fresco::SafeTensors contents;
    std::uint64_t seed = 1;
    for (const auto& shape : vgg19_shapes(last))
    {
        const double deviation = std::sqrt(2.0 / (9 * static_cast<double>(shape.inputs)));
        contents.tensors[std::string(shape.name) + ".weight"] = noise({shape.outputs, shape.inputs, 3, 3}, deviation, ++seed);
        contents.tensors[std::string(shape.name) + ".bias"] = noise({shape.outputs}, 0.1, ++seed);
    }
    fresco::write_safetensors(file, contents);
}

void prepare(const std::vector<std::shared_ptr<fresco::Loss>>& losses, int height_px)
{
    static fresco::Progress progress;  // Losses may keep it for as long as they live.
    fresco::PrepareContext context;
    context.style.fine = fresco::to_tensor(generated_style(256, 256));
    context.style.coarse = fresco::to_tensor(generated_style(512, 512));
    context.camera_samples = {fresco::to_tensor(generated_camera_picture(height_px * 4 / 3, height_px))};
    context.progress = &progress;
    std::set<const fresco::FeatureNetwork*> prepared;
    for (const auto& loss : losses)
        for (const auto& layers : loss->needs().features)
            if (prepared.insert(layers.network).second)
                layers.network->prepare(context);
    for (const auto& loss : losses)
        loss->prepare(context);
}

}  // namespace bench
