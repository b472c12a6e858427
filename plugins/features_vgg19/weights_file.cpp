#include "vgg19.h"

#include <fresco/error.h>

#include <ATen/ATen.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace vgg19
{
namespace
{

struct Entry
{
    int block;
    int number;       ///< within the block
    int torchvision;  ///< N of "features.N"
    int outputs;
};

constexpr std::array<Entry, 16> architecture{{{1, 1, 0, 64},
                                              {1, 2, 2, 64},
                                              {2, 1, 5, 128},
                                              {2, 2, 7, 128},
                                              {3, 1, 10, 256},
                                              {3, 2, 12, 256},
                                              {3, 3, 14, 256},
                                              {3, 4, 16, 256},
                                              {4, 1, 19, 512},
                                              {4, 2, 21, 512},
                                              {4, 3, 23, 512},
                                              {4, 4, 25, 512},
                                              {5, 1, 28, 512},
                                              {5, 2, 30, 512},
                                              {5, 3, 32, 512},
                                              {5, 4, 34, 512}}};

std::string suffix(const Entry& entry)
{
    return std::to_string(entry.block) + "_" + std::to_string(entry.number);
}

std::string torchvision_key(const Entry& entry)
{
    return "features." + std::to_string(entry.torchvision);
}

bool uses_torchvision_keys(const fresco::SafeTensors& contents)
{
    return contents.tensors.contains(torchvision_key(architecture[0]) + ".weight");
}

std::string lower_case(std::string text)
{
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string shape_text(c10::IntArrayRef shape)
{
    std::string text;
    for (const auto size : shape)
        text += (text.empty() ? "" : " x ") + std::to_string(size);
    return text;
}

torch::Tensor checked(const fresco::SafeTensors& contents, const std::string& name, std::vector<std::int64_t> shape,
                      const std::filesystem::path& file)
{
    const auto found = contents.tensors.find(name);
    if (found == contents.tensors.end())
        throw fresco::Error(file.string() + ": tensor '" + name + "' is missing; VGG-19 needs it beside its other half");
    const auto& tensor = found->second;
    if (tensor.sizes() != c10::IntArrayRef(shape))
        throw fresco::Error(file.string() + ": tensor '" + name + "' is " + shape_text(tensor.sizes()) + ", VGG-19 has " +
                            shape_text(shape) + " there; give the weights of VGG-19");
    if (!tensor.is_floating_point())
        throw fresco::Error(file.string() + ": tensor '" + name + "' does not hold floating-point numbers");
    auto values = tensor.to(at::kFloat).contiguous();
    if (!at::isfinite(values).all().item<bool>())
        throw fresco::Error(file.string() + ": tensor '" + name + "' holds values that are not finite");
    return values;
}

}  // namespace

InputFormat caffe_input()
{
    return {.bgr = true, .scale = 255, .mean = {103.939, 116.779, 123.68}, .deviation = {1, 1, 1}, .padding = Padding::reflect};
}

InputFormat torchvision_input()
{
    return {
        .bgr = false, .scale = 1, .mean = {0.485, 0.456, 0.406}, .deviation = {0.229, 0.224, 0.225}, .padding = Padding::zero};
}

InputFormat input_format(const fresco::SafeTensors& contents, const std::filesystem::path& file)
{
    auto format = uses_torchvision_keys(contents) ? torchvision_input() : caffe_input();
    if (const auto input = contents.metadata.find("input"); input != contents.metadata.end())
    {
        const auto text = lower_case(input->second);
        const auto padding = format.padding;
        if (text.find("bgr") != std::string::npos && text.find("255") != std::string::npos)
            format = caffe_input();
        else if (text.find("rgb") != std::string::npos &&
                 (text.find("imagenet") != std::string::npos || text.find("0.485") != std::string::npos))
            format = torchvision_input();
        else
            throw fresco::Error(
                file.string() + ": metadata 'input' is \"" + input->second +
                "\"; known are \"BGR in 0..255 minus (103.939, 116.779, 123.68)\" and \"RGB in [0,1], ImageNet mean "
                "and deviation\"");
        format.padding = padding;
    }
    if (const auto entry = contents.metadata.find("padding"); entry != contents.metadata.end())
    {
        const auto text = lower_case(entry->second);
        if (text != "reflect" && text != "zero" && text != "zeros")
            throw fresco::Error(file.string() + ": metadata 'padding' is \"" + entry->second + "\"; known are reflect and zero");
        format.padding = text == "reflect" ? Padding::reflect : Padding::zero;
    }
    return format;
}

std::vector<Convolution> convolutions(const fresco::SafeTensors& contents, const std::filesystem::path& file)
{
    const bool torchvision = uses_torchvision_keys(contents);
    const auto key = [&](const Entry& entry) { return torchvision ? torchvision_key(entry) : "conv" + suffix(entry); };
    std::vector<Convolution> result;
    std::string gap;
    std::int64_t inputs = 3;
    for (const auto& entry : architecture)
    {
        const auto name = key(entry);
        if (!contents.tensors.contains(name + ".weight"))
        {
            if (gap.empty())
                gap = name + ".weight";
            continue;
        }
        if (!gap.empty())
            throw fresco::Error(file.string() + ": tensor '" + gap + "' is missing, though '" + name +
                                ".weight' after it is there; layers must be given without a gap");
        Convolution convolution;
        convolution.layer = "relu" + suffix(entry);
        convolution.weights = checked(contents, name + ".weight", {entry.outputs, inputs, 3, 3}, file);
        convolution.bias = checked(contents, name + ".bias", {entry.outputs}, file);
        convolution.pooled = entry.block > 1 && entry.number == 1;
        inputs = entry.outputs;
        result.push_back(std::move(convolution));
    }
    if (result.empty())
        throw fresco::Error(
            file.string() +
            ": holds neither 'features.0.weight' (torchvision's names) nor 'conv1_1.weight' (Gatys'): not the weights "
            "of VGG-19");
    return result;
}

}  // namespace vgg19
