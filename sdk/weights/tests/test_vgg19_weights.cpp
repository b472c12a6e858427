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

}  // namespace

TEST_CASE("Layers are found by torchvision's names and by Caffe's")
{
    Contents torchvision;
    torchvision.add("classifier.0.weight", {2, 2});
    const auto first = recognized(torchvision);
    CHECK(first.keys == Vgg19Keys::torchvision);
    CHECK(first.ignored == std::vector<std::string>{"classifier.0.weight"});
    REQUIRE(first.layers.size() == 3);
    CHECK(first.layers[2].name == "2_1");
    CHECK((!first.layers[1].pooled && first.layers[2].pooled));
    CHECK_FALSE(first.raw);
    CHECK_FALSE(first.input.bgr);
    CHECK(first.input.padding == Vgg19Padding::zero);

    const auto second = recognized(Contents({"conv1_1", "conv1_2"}));
    CHECK(second.keys == Vgg19Keys::caffe);
    CHECK(second.layers.size() == 2);
    CHECK(second.raw);
    CHECK(second.input.bgr);
    CHECK(second.input.padding == Vgg19Padding::zero);
}

TEST_CASE("All sixteen layers, as long as they are there")
{
    std::vector<std::string> names, keys;
    for (const auto& [block, layers] : {std::pair{1, 2}, {2, 2}, {3, 4}, {4, 4}, {5, 4}})
        for (int layer = 1; layer <= layers; ++layer)
        {
            names.push_back(fmt::format("{}_{}", block, layer));
            keys.push_back("conv" + names.back());
        }
    const Contents contents(keys);
    const auto weights = recognized(contents);
    REQUIRE(weights.layers.size() == 16);
    for (std::size_t i = 0; i < 16; ++i)
        CHECK(weights.layers[i].name == names[i]);
    CHECK(vgg19_metadata(weights).at("architecture") == "VGG-19, conv1_1 to conv5_4");
}

TEST_CASE("Metadata decides over names")
{
    Contents contents;
    auto& metadata = contents.dict.metadata;
    metadata["input"] = "BGR in 0..255 minus (103.939, 116.779, 123.68)";
    CHECK(recognized(contents).input.bgr);
    CHECK(recognized(contents).input.padding == Vgg19Padding::zero);
    metadata["padding"] = "reflect";
    CHECK(recognized(contents).input.padding == Vgg19Padding::reflect);
    metadata["normalized"] = "weights rescaled to unit mean activation (Gatys)";
    CHECK_FALSE(recognized(contents).raw);
    metadata["scale"] = "raw";
    CHECK(recognized(contents).raw);
    Contents caffe({"conv1_1"});
    caffe.dict.metadata["normalized"] = "unit mean activation";
    CHECK_FALSE(recognized(caffe).raw);
    caffe.dict.metadata = {{"scale", "other"}};
    CHECK_FALSE(recognized(caffe).raw);
    // Written weights are read back unchanged.
    Contents again;
    again.dict.metadata = vgg19_metadata(recognized(contents));
    CHECK(vgg19_metadata(recognized(again)) == again.dict.metadata);

    const auto refused = [](Contents changed, const char* key, const char* value)
    {
        changed.dict.metadata[key] = value;
        CHECK_THROWS_WITH(recognized(changed), Catch::Contains("w.pth") && Catch::Contains(key) && Catch::Contains(value));
    };
    refused(contents, "padding", "circular");
    refused(contents, "input", "YUV");
    refused(contents, "scale", "perhaps");
    metadata.erase("scale");
    refused(contents, "normalized", "perhaps");
}

TEST_CASE("What is not VGG-19 is refused with the tensor's name")
{
    const auto refused = [](const std::function<void(Contents&)>& change, const std::string& tensor)
    {
        Contents contents;
        change(contents);
        CHECK_THROWS_WITH(recognized(contents), Catch::Contains("w.pth") && Catch::Contains(tensor));
    };
    refused([](Contents& c) { c.add("features.2.weight", {64, 32, 3, 3}); }, "'features.2.weight' is 64 x 32 x 3 x 3");
    refused([](Contents& c) { c.add("features.5.bias", {64}); }, "features.5.bias");
    for (const std::string missing : {"features.2.bias", "features.2.weight", "features.0.weight"})
        refused([&](Contents& c) { c.remove(missing); }, missing);
    refused([](Contents& c) { c.add("features.0.weight", {64, 3, 3, 3}, ElementType::int32); }, "features.0.weight");
    refused([](Contents& c) { c.add("features.1.running_mean", {64}); }, "batch normalization");
}
