#include "dictionary.h"

#include "spherical_k_means.h"
#include "whitening.h"

#include <fresco/error.h>
#include <fresco/random.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dictionary
{
namespace
{

struct Shape
{
    int outputs;
    int size;
};
constexpr std::array<Shape, 4> shapes{{{64, 5}, {96, 3}, {128, 3}, {128, 3}}};
constexpr std::int64_t smallest_side = 64;

/// Reflected where the picture is large enough for it, else repeated.
torch::Tensor padded(const torch::Tensor& maps, std::int64_t by)
{
    const bool reflect = maps.size(1) > by && maps.size(2) > by;
    const std::vector<std::int64_t> sides{by, by, by, by};
    const auto batch = maps.unsqueeze(0);
    return reflect ? at::reflection_pad2d(batch, sides) : at::replication_pad2d(batch, sides);
}

torch::Tensor respond(const torch::Tensor& maps, const Layer& layer)
{
    if (maps.numel() == 0)
        return maps.new_empty({layer.filters.size(0), maps.size(1), maps.size(2)});
    const auto filters = layer.filters.to(maps.scalar_type());
    const auto bias = layer.bias.to(maps.scalar_type());
    return at::relu(at::conv2d(padded(maps, layer.filters.size(2) / 2), filters, bias)).squeeze(0);
}

torch::Tensor halved(const torch::Tensor& maps)
{
    if (maps.size(1) < 2 || maps.size(2) < 2)
        return maps.new_empty({maps.size(0), maps.size(1) / 2, maps.size(2) / 2});
    return at::avg_pool2d(maps.unsqueeze(0), {2, 2}).squeeze(0);
}

/// What layer `index` gives for its input, with the plain colours joined to the first.
torch::Tensor layer_output(std::size_t index, const torch::Tensor& input, const Layer& layer)
{
    const auto responses = respond(input, layer);
    return index == 0 ? at::cat({responses, input}, 0) : responses;
}

torch::Tensor with_noise(const torch::Tensor& picture, double deviation, fresco::Random& random)
{
    auto noisy = picture.clone(at::MemoryFormat::Contiguous);
    float* value = noisy.data_ptr<float>();
    for (std::int64_t i = 0; i < noisy.numel(); ++i)
        value[i] += static_cast<float>(deviation * random.normal());
    return noisy;
}

/// `count` patches of `size` x `size` at seeded places wholly inside, as rows of C · size · size.
torch::Tensor draw_patches(const torch::Tensor& maps, int size, std::int64_t count, fresco::Random& random)
{
    const auto input = maps.contiguous();
    const auto channels = input.size(0);
    const auto height = input.size(1);
    const auto width = input.size(2);
    auto rows = at::empty({count, channels * size * size}, at::kFloat);
    float* out = rows.data_ptr<float>();
    for (std::int64_t i = 0; i < count; ++i)
    {
        const auto y = random.below(height - size + 1);
        const auto x = random.below(width - size + 1);
        for (std::int64_t c = 0; c < channels; ++c)
            for (std::int64_t j = 0; j < size; ++j)
                out = std::copy_n(input.data_ptr<float>() + (c * height + y + j) * width + x, size, out);
    }
    return rows;
}

/// Filter and bias that give (a·x - mean) / deviation over the patches, for a = transformᵀ · centre.
Layer standardised(const torch::Tensor& patches, const Whitening& whitening, const torch::Tensor& centres, const Shape& shape)
{
    const auto directions = fresco::matrix_product(centres, whitening.transform).contiguous();
    const auto responses = fresco::matrix_product(directions, (patches - whitening.mean).t().contiguous()).contiguous();
    const auto count = responses.size(1);
    const auto channels = patches.size(1) / (shape.size * shape.size);
    Layer layer{at::empty({shape.outputs, channels, shape.size, shape.size}, at::kFloat), at::empty({shape.outputs}, at::kFloat)};
    const auto width = patches.size(1);
    for (std::int64_t k = 0; k < shape.outputs; ++k)
    {
        const float* row = responses.data_ptr<float>() + k * count;
        double sum = 0;
        double squares = 0;
        for (std::int64_t i = 0; i < count; ++i)
        {
            sum += static_cast<double>(row[i]);
            squares += static_cast<double>(row[i]) * static_cast<double>(row[i]);
        }
        const double mean = sum / static_cast<double>(count);
        const double deviation = std::sqrt(std::max(squares / static_cast<double>(count) - mean * mean, 1e-12));
        double offset = mean;
        for (std::int64_t j = 0; j < width; ++j)
        {
            const auto direction = static_cast<double>(directions.data_ptr<float>()[k * width + j]);
            layer.filters.data_ptr<float>()[k * width + j] = static_cast<float>(direction / deviation);
            offset += direction * static_cast<double>(whitening.mean.data_ptr<float>()[j]);
        }
        layer.bias.data_ptr<float>()[k] = static_cast<float>(-offset / deviation);
    }
    return layer;
}

}  // namespace

Dictionary Dictionary::learn(const torch::Tensor& picture, const LearnOptions& options, fresco::Progress& progress)
{
    if (picture.dim() != 3 || picture.size(0) != 3 || std::min(picture.size(1), picture.size(2)) < smallest_side)
        throw fresco::Error("The style picture has " + std::to_string(picture.size(-1)) + " x " +
                            std::to_string(picture.size(-2)) + " pixels; a dictionary of features needs at least " +
                            std::to_string(smallest_side) + " on both sides: use a larger picture");
    const at::NoGradGuard no_gradient;
    fresco::Random random(options.seed);
    auto clean = picture.to(at::kCPU, at::kFloat).contiguous();
    auto noisy = with_noise(clean, options.noise, random);
    Dictionary result;
    for (std::size_t index = 0; index < shapes.size(); ++index)
    {
        progress.check_cancelled();
        const auto& shape = shapes[index];
        const auto half = std::max(options.patches / 2, 1);
        const auto patches =
            at::cat({draw_patches(clean, shape.size, half, random), draw_patches(noisy, shape.size, half, random)});
        const auto whitening = learn_whitening(patches, options.epsilon);
        const auto white = fresco::matrix_product(patches - whitening.mean, whitening.transform.t().contiguous());
        const auto centres = spherical_k_means(white, shape.outputs, options.iterations, random, progress);
        result.layers_.push_back(standardised(patches, whitening, centres, shape));
        if (index + 1 == shapes.size())
            break;
        clean = halved(layer_output(index, clean, result.layers_.back()));
        noisy = halved(layer_output(index, noisy, result.layers_.back()));
    }
    return result;
}

void Dictionary::move_to(const torch::Device& device)
{
    for (auto& layer : layers_)
    {
        layer.filters = layer.filters.to(device);
        layer.bias = layer.bias.to(device);
    }
}

std::vector<fresco::FeatureLayer> Dictionary::layers()
{
    std::vector<fresco::FeatureLayer> result;
    int stride = 1;
    int margin = 0;
    for (std::size_t index = 0; index < shapes.size(); ++index)
    {
        margin += shapes[index].size / 2 * stride;
        fresco::FeatureLayer layer;
        layer.name = "d" + std::to_string(index + 1);
        layer.channels = shapes[index].outputs + (index == 0 ? 3 : 0);
        layer.stride = stride;
        layer.margin_px = margin;
        layer.style = true;
        layer.content = index + 1 == shapes.size();
        result.push_back(layer);
        stride *= 2;
    }
    return result;
}

std::vector<torch::Tensor> Dictionary::encode(const torch::Tensor& picture, std::size_t count) const
{
    std::vector<torch::Tensor> result;
    torch::Tensor maps = picture;
    for (std::size_t index = 0; index < std::min(count, layers_.size()); ++index)
    {
        if (index > 0)
            maps = halved(maps);
        maps = layer_output(index, maps, layers_[index]);
        result.push_back(maps);
    }
    return result;
}

}  // namespace dictionary
