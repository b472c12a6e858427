#pragma once

#include <fresco/testing.h>
#include <fresco/torch/loss.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace bench
{

/// Components from the plugins of this build: type a.b is in a_b.so.
class Components
{
  public:
    Components();

    /// `config` holds "type" and options. Throws fresco::Error for an unknown type or option, or another contract.
    template <class T>
    std::shared_ptr<T> make(const fresco::Value& config)
    {
        const auto made = std::dynamic_pointer_cast<T>(factory_.create(T::component_kind, config));
        if (!made)
            throw fresco::Error("a component is not of the kind asked for");
        return made;
    }

  private:
    fresco::testing::TestFactory factory_;
};

/// One of VGG-19's convolutions of 3 x 3.
struct ConvolutionShape
{
    const char* name;
    std::int64_t outputs;
    std::int64_t inputs;
    int stride;  ///< Of its input, in pixels of the picture.
};

/// From conv1_1 to `last`.
std::vector<ConvolutionShape> vgg19_shapes(std::string_view last);

/// VGG-19 up to `last` with random weights (He's deviation, so that responses keep their size) under Caffe's keys.
void write_random_vgg19(const std::filesystem::path& file, std::string_view last = "conv4_2");

/// Prepares the networks that the losses need, each once, and then the losses, for the generated style and camera picture.
void prepare(const std::vector<std::shared_ptr<fresco::Loss>>& losses, int height_px);

}  // namespace bench
