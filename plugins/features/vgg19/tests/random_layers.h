#pragma once

#include "random_tensor.h"
#include "vgg19.h"

#include <cmath>
#include <cstdint>
#include <vector>

/// conv1_1 .. conv3_1 in VGG's shapes.
inline std::vector<vgg19::Convolution> random_layers()
{
    struct Shape
    {
        const char* name;
        std::int64_t outputs;
        std::int64_t inputs;
        bool pooled;
    };
    std::vector<vgg19::Convolution> result;
    for (const auto& [name, outputs, inputs, pooled] :
         {Shape{"relu1_1", 64, 3, false}, Shape{"relu1_2", 64, 64, false}, Shape{"relu2_1", 128, 64, true},
          Shape{"relu2_2", 128, 128, false}, Shape{"relu3_1", 256, 128, true}})
        result.push_back({name,
                          fresco::testing::random_tensor({outputs, inputs, 3, 3}, result.size()) *
                              (2 / std::sqrt(static_cast<double>(inputs))),
                          fresco::testing::random_tensor({outputs}, 10 + result.size()) * 0.2, pooled});
    return result;
}
