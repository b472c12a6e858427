#include <fresco/torch/lazy_tensor.h>
#include <fresco/torch/tensor.h>

#include <fresco/files_io.h>
#include <fresco/weights/state_dict.h>
#include <fresco/weights/write_safetensors.h>

#include <ATen/ops/empty.h>

#include <array>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace fresco
{
namespace
{

using weights::ElementType;

struct TypePair
{
    at::ScalarType type;
    ElementType element;
    bool written;
};
constexpr std::array<TypePair, 10> type_pairs{{{at::kDouble, ElementType::float64, true},
                                               {at::kLong, ElementType::int64, true},
                                               {at::kFloat, ElementType::float32, true},
                                               {at::kInt, ElementType::int32, true},
                                               {at::kHalf, ElementType::float16, false},
                                               {at::kBFloat16, ElementType::bfloat16, false},
                                               {at::kShort, ElementType::int16, false},
                                               {at::kByte, ElementType::uint8, true},
                                               {at::kChar, ElementType::int8, false},
                                               {at::kBool, ElementType::boolean, true}}};

torch::Tensor to_tensor(const weights::TensorView& view)
{
    const auto& pair = type_pairs.at(static_cast<std::size_t>(view.type));
    constexpr std::size_t large = std::size_t{1} << 20U;
    const std::vector<std::int64_t> shape(view.shape.begin(), view.shape.end());
    if (view.bytes.size() >= large)
    {
        // Much of a large texture's checkpoint is zero.
        auto result = lazy_zeros(shape, pair.type);
        write_bytes(view.bytes, result);
        return result;
    }
    auto result = at::empty(shape, pair.type);
    if (!view.bytes.empty())
        std::memcpy(result.data_ptr(), view.bytes.data(), view.bytes.size());
    return result;
}

ElementType written_type(const std::string& name, const torch::Tensor& tensor)
{
    for (const auto& pair : type_pairs)
        if (pair.type == tensor.scalar_type() && pair.written)
            return pair.element;
    throw std::invalid_argument("write_safetensors: tensor '" + name + "' has a type that is not written");
}

}  // namespace

SafeTensors read_safetensors(const std::filesystem::path& file)
{
    const auto bytes = read_file(file);
    auto contents = weights::parse_safetensors(bytes, file.string());
    SafeTensors result;
    for (const auto& view : contents.tensors)
        result.tensors.emplace(view.name, to_tensor(view));
    result.metadata = std::move(contents.metadata);
    return result;
}

void write_safetensors(const std::filesystem::path& file, const SafeTensors& contents)
{
    std::vector<torch::Tensor> kept;
    std::vector<weights::TensorView> views;
    for (const auto& [name, tensor] : contents.tensors)
    {
        const ElementType type = written_type(name, tensor);
        kept.push_back(tensor.detach().to(at::kCPU).contiguous());
        views.push_back({name,
                         type,
                         {kept.back().sizes().begin(), kept.back().sizes().end()},
                         {static_cast<const std::byte*>(kept.back().data_ptr()), kept.back().nbytes()}});
    }
    weights::write_safetensors(file, views, contents.metadata);
}

}  // namespace fresco
