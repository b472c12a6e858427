#include <fresco/weights/vgg19.h>

#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <set>

namespace fresco::weights
{
namespace
{

struct Convolution
{
    int block;
    int number;       ///< within the block
    int torchvision;  ///< N of "features.N"
    std::size_t outputs;
};

std::vector<Convolution> architecture()
{
    std::vector<Convolution> all;
    int torchvision = 0;
    std::size_t outputs = 64;
    int block = 0;
    for (const int convolutions : {2, 2, 4, 4, 4})
    {
        ++block;
        // Behind each one stands a ReLU in torchvision's list, and behind a block a pooling.
        for (int number = 1; number <= convolutions; ++number, torchvision += 2)
            all.push_back({block, number, torchvision, outputs});
        ++torchvision;
        outputs = std::min<std::size_t>(2 * outputs, 512);
    }
    return all;
}

std::string layer_name(const Convolution& convolution)
{
    return fmt::format("{}_{}", convolution.block, convolution.number);
}

std::string key_of(const Convolution& convolution, Vgg19Keys keys)
{
    return keys == Vgg19Keys::torchvision ? "features." + std::to_string(convolution.torchvision)
                                          : "conv" + layer_name(convolution);
}

bool is_of_classifier(std::string_view name)
{
    return name.starts_with("classifier.") || name.starts_with("fc");
}

class Recognizer
{
  public:
    Recognizer(const StateDict& contents, std::string_view source) : contents_(contents), source_(source) {}

    Vgg19Weights recognize()
    {
        Vgg19Weights result;
        if (contents_.find("features.0.weight") != nullptr)
            result.keys = Vgg19Keys::torchvision;
        else if (contents_.find("conv1_1.weight") != nullptr)
            result.keys = Vgg19Keys::caffe;
        else
            fail("holds neither 'features.0.weight' (torchvision's names) nor 'conv1_1.weight' (Caffe's): not the weights of "
                 "VGG-19");
        read_layers(result);
        for (const auto& tensor : contents_.tensors)
        {
            if (is_of_classifier(tensor.name))
                result.ignored.push_back(tensor.name);
            else if (!taken_.contains(tensor.name))
                fail("tensor '" + tensor.name +
                     "' is not one of VGG-19's; use the weights of VGG-19 without batch normalization");
        }
        result.input = input(result.keys);
        result.raw = is_raw(result.keys);
        return result;
    }

  private:
    [[noreturn]] void fail(const std::string& what) const { throw Error(source_ + ": " + what); }

    void read_layers(Vgg19Weights& result)
    {
        std::string gap;
        std::size_t inputs = 3;
        for (const auto& convolution : architecture())
        {
            const auto key = key_of(convolution, result.keys);
            if (contents_.find(key + ".weight") == nullptr)
            {
                if (gap.empty())
                    gap = key + ".weight";
                continue;
            }
            if (!gap.empty())
                fail("tensor '" + gap + "' is missing, though '" + key +
                     ".weight' after it is there; layers must be given without a gap");
            Vgg19Layer layer;
            layer.name = layer_name(convolution);
            layer.weight = checked(key + ".weight", {convolution.outputs, inputs, 3, 3});
            layer.bias = checked(key + ".bias", {convolution.outputs});
            layer.pooled = convolution.block > 1 && convolution.number == 1;
            inputs = convolution.outputs;
            result.layers.push_back(std::move(layer));
        }
    }

    TensorView checked(const std::string& name, const std::vector<std::size_t>& shape)
    {
        const TensorView* tensor = contents_.find(name);
        if (tensor == nullptr)
            fail("tensor '" + name + "' is missing; VGG-19 needs it beside its other half");
        if (tensor->shape != shape)
            fail("tensor '" + name + "' is " + shape_text(tensor->shape) + ", VGG-19 has " + shape_text(shape) +
                 " there; use the weights of VGG-19");
        if (!is_floating(tensor->type))
            fail("tensor '" + name + "' does not hold floating-point numbers");
        taken_.insert(name);
        return *tensor;
    }

    /// In lower case.
    std::optional<std::string> entry(const char* name) const
    {
        const auto found = contents_.metadata.find(name);
        return found == contents_.metadata.end() ? std::nullopt : std::optional(lower_case(found->second));
    }

    [[noreturn]] void unknown(const char* name, const std::string& known) const
    {
        fail("metadata '" + std::string(name) + "' is \"" + contents_.metadata.at(name) + "\"; " + known);
    }

    Vgg19Input input(Vgg19Keys keys) const
    {
        auto result = keys == Vgg19Keys::torchvision ? torchvision_input() : caffe_input();
        if (const auto text = entry("input"))
        {
            const auto has = [&](const char* word) { return text->find(word) != std::string::npos; };
            if (has("bgr") && has("255"))
                result = caffe_input();
            else if (has("rgb") && (has("imagenet") || has("0.485")))
                result = torchvision_input();
            else
                unknown("input",
                        fmt::format("known are \"{}\" and \"{}\"", input_text(caffe_input()), input_text(torchvision_input())));
        }
        if (const auto text = entry("padding"))
        {
            if (*text != "reflect" && *text != "zero" && *text != "zeros")
                unknown("padding", "known are reflect and zero");
            result.padding = *text == "reflect" ? Vgg19Padding::reflect : Vgg19Padding::zero;
        }
        return result;
    }

    bool is_raw(Vgg19Keys keys) const
    {
        if (const auto text = entry("scale"))
        {
            if (*text != "raw" && *text != "other")
                unknown("scale", "known are raw and other");
            return *text == "raw";
        }
        return keys == Vgg19Keys::caffe;
    }

    const StateDict& contents_;
    std::string source_;
    std::set<std::string> taken_;
};

}  // namespace

Vgg19Input caffe_input()
{
    return {.bgr = true, .scale = 255, .mean = {103.939, 116.779, 123.68}};
}

Vgg19Input torchvision_input()
{
    return {.mean = {0.485, 0.456, 0.406}, .deviation = {0.229, 0.224, 0.225}};
}

std::string_view input_text(const Vgg19Input& input)
{
    return input.bgr ? "BGR in 0..255 minus (103.939, 116.779, 123.68)" : "RGB in [0,1], ImageNet mean and deviation";
}

std::string_view padding_text(Vgg19Padding padding)
{
    return padding == Vgg19Padding::zero ? "zero" : "reflect";
}

Vgg19Weights recognize_vgg19(const StateDict& contents, std::string_view source)
{
    return Recognizer(contents, source).recognize();
}

std::map<std::string, std::string> vgg19_metadata(const Vgg19Weights& weights)
{
    return {{"architecture", "VGG-19, conv1_1 to conv" + weights.layers.back().name},
            {"input", std::string(input_text(weights.input))},
            {"padding", std::string(padding_text(weights.input.padding))},
            {"scale", weights.raw ? "raw" : "other"}};
}

}  // namespace fresco::weights
