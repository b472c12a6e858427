#pragma once

#include <fresco/testing.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <tuple>

/// \file Components from the plugins of this build, and a network with random weights for them.

/// A component of this build, configured: type a.b is in a_b.so.
template <class Contract>
std::shared_ptr<Contract> made(const std::string& type, const fresco::Value& options, fresco::ComponentFactory& factory)
{
    std::string file = type;
    file[file.find('.')] = '_';
    auto component =
        fresco::testing::make_from_plugin<Contract>(std::filesystem::path(FRESCO_PLUGIN_FOLDER) / (file + ".so"), type);
    component->configure(options, factory);
    return component;
}

/// Writes weights of VGG-19 up to a block, or to conv5_1, under Caffe's keys, drawn so that activations keep their size.
inline std::filesystem::path random_vgg19(const std::filesystem::path& folder, int last_block)
{
    fresco::SafeTensors contents;
    at::manual_seed(5);
    std::int64_t inputs = 3;
    for (const auto& [block, outputs, count] : {std::tuple{1, 64, 2}, {2, 128, 2}, {3, 256, 4}, {4, 512, 4}, {5, 512, 1}})
        for (int number = 1; number <= count && block <= last_block; ++number)
        {
            const std::string name = "conv" + std::to_string(block) + "_" + std::to_string(number);
            const double deviation = std::sqrt(2.0 / (9.0 * static_cast<double>(inputs))) / (inputs == 3 ? 64 : 1);
            contents.tensors[name + ".weight"] = at::randn({outputs, inputs, 3, 3}) * deviation;
            contents.tensors[name + ".bias"] = at::zeros({outputs});
            inputs = outputs;
        }
    write_safetensors(folder / "vgg19.safetensors", contents);
    return folder / "vgg19.safetensors";
}
