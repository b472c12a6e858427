#include "made_weights.h"

#include <fresco/weights/vgg19.h>

#include <fmt/format.h>
#include <functional>

using namespace fresco::weights;

namespace
{

/// Convolutions from conv1_1 on; all elements are 0.
struct Contents
{
    std::vector<std::byte> zeros = std::vector<std::byte>(std::size_t{512} * 512 * 9 * 4);
    StateDict dict;

    explicit Contents(const std::vector<std::string>& keys = {"features.0", "features.2", "features.5"})
    {
        const std::size_t outputs[] = {64, 64, 128, 128, 256, 256, 256, 256, 512, 512, 512, 512, 512, 512, 512, 512};
        std::size_t inputs = 3;
        for (std::size_t i = 0; i < keys.size(); ++i)
        {
            add(keys[i] + ".weight", {outputs[i], inputs, 3, 3});
            add(keys[i] + ".bias", {outputs[i]});
            inputs = outputs[i];
        }
    }
    TensorView& add(const std::string& name, const std::vector<std::size_t>& shape, ElementType type = ElementType::float32)
    {
        std::erase_if(dict.tensors, [&](const TensorView& tensor) { return tensor.name == name; });
        std::size_t size = size_of(type);
        for (const auto extent : shape)
            size *= extent;
        return dict.tensors.emplace_back(TensorView{name, type, shape, std::span(zeros).first(size)});
    }
    void remove(const std::string& name)
    {
        std::erase_if(dict.tensors, [&](const TensorView& tensor) { return tensor.name == name; });
    }
};

Vgg19Weights recognized(const Contents& contents)
{
    return recognize_vgg19(contents.dict, "w.pth");
}

/// The last layer, and what the weights are for.
std::string described(const Contents& contents)
{
    const auto said = vgg19_metadata(recognized(contents));
    CHECK(said.at("architecture").starts_with("VGG-19, conv1_1 to conv"));
    return said.at("architecture").substr(19) + ", " + said.at("input").substr(0, 3) + ", " + said.at("padding") + ", " +
           said.at("scale");
}

}  // namespace

TEST_CASE("Layers are found by torchvision's names and by Caffe's, as long as they are there, and say what they are for")
{
    CHECK(described(Contents()) == "conv2_1, RGB, zero, other");
    CHECK(described(Contents({"conv1_1", "conv1_2"})) == "conv1_2, BGR, zero, raw");
    Contents torchvision;
    torchvision.add("classifier.0.weight", {2, 2});
    const auto first = recognized(torchvision);
    CHECK((first.keys == Vgg19Keys::torchvision && !first.layers[1].pooled && first.layers[2].pooled));
    CHECK(first.ignored == std::vector<std::string>{"classifier.0.weight"});

    std::vector<std::string> keys;
    for (const auto& [block, layers] : {std::pair{1, 2}, {2, 2}, {3, 4}, {4, 4}, {5, 4}})
        for (int layer = 1; layer <= layers; ++layer)
            keys.push_back(fmt::format("conv{}_{}", block, layer));
    const auto whole = recognized(Contents(keys));
    CHECK(whole.keys == Vgg19Keys::caffe);
    REQUIRE(whole.layers.size() == 16);
    for (std::size_t i = 0; i < 16; ++i)
        CHECK("conv" + whole.layers[i].name == keys[i]);
}

TEST_CASE("Metadata decides over names")
{
    Contents contents;
    auto& metadata = contents.dict.metadata;
    metadata["input"] = "BGR in 0..255 minus (103.939, 116.779, 123.68)";
    CHECK(described(contents) == "conv2_1, BGR, zero, other");
    metadata["padding"] = "reflect";
    CHECK(described(contents) == "conv2_1, BGR, reflect, other");
    metadata["scale"] = "raw";
    CHECK(described(contents) == "conv2_1, BGR, reflect, raw");
    Contents caffe({"conv1_1"});
    caffe.dict.metadata = {{"scale", "other"}};
    CHECK(described(caffe) == "conv1_1, BGR, zero, other");
    // Written weights are read back unchanged.
    Contents again;
    again.dict.metadata = vgg19_metadata(recognized(contents));
    CHECK(described(again) == described(contents));

    const auto refused = [](Contents changed, const char* key, const char* value)
    {
        changed.dict.metadata[key] = value;
        CHECK_THROWS_WITH(recognized(changed), Contains("w.pth") && Contains(key) && Contains(value));
    };
    refused(contents, "padding", "circular");
    refused(contents, "input", "YUV");
    refused(contents, "scale", "perhaps");
}

TEST_CASE("What is not VGG-19 is refused with the tensor's name")
{
    const auto refused = [](const std::function<void(Contents&)>& change, const std::string& tensor)
    {
        Contents contents;
        change(contents);
        CHECK_THROWS_WITH(recognized(contents), Contains("w.pth") && Contains(tensor));
    };
    refused([](Contents& c) { c.add("features.2.weight", {64, 32, 3, 3}); }, "'features.2.weight' is 64 x 32 x 3 x 3");
    refused([](Contents& c) { c.add("features.5.bias", {64}); }, "features.5.bias");
    for (const std::string missing : {"features.2.bias", "features.2.weight", "features.0.weight"})
        refused([&](Contents& c) { c.remove(missing); }, missing);
    refused([](Contents& c) { c.add("features.0.weight", {64, 3, 3, 3}, ElementType::int32); }, "features.0.weight");
    refused([](Contents& c) { c.add("features.1.running_mean", {64}); }, "batch normalization");
}
