#include "encoder.h"

#include <fresco/parallel.h>

#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/empty_strided.h>
#include <ATen/ops/max_pool2d.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <span>
#include <utility>

namespace vgg19
{
namespace
{

// at::parallel_for is serial in code that is not compiled with OpenMP.
void on_all_threads(std::size_t count, const std::function<void(std::size_t, std::size_t)>& work)
{
    fresco::parallel_for(count, 1, at::get_num_threads(), work);
}

std::span<const float> values_of(const torch::Tensor& tensor)
{
    return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
}

int channels_of(const torch::Tensor& weights, std::int64_t dimension)
{
    return static_cast<int>(weights.size(dimension));
}

/// C x H x W, with the channels innermost in memory.
torch::Tensor room_for(MapsShape shape, at::ScalarType type)
{
    const std::int64_t pixel = shape.channels;
    return at::empty_strided({pixel, shape.height, shape.width}, {1, shape.width * pixel, pixel}, type);
}

Border border_of(fresco::weights::Vgg19Padding padding)
{
    return padding == fresco::weights::Vgg19Padding::zero ? Border::zero : Border::reflect;
}

/// The largest value of each square of pixels.
fresco::Raster8 largest(const fresco::Raster8& mask, std::int64_t side, std::int64_t stride, std::int64_t border)
{
    const auto floats = at::empty({1, mask.height, mask.width}, at::kFloat);
    std::ranges::copy(mask.values, floats.data_ptr<float>());
    const auto pooled = at::max_pool2d(floats, side, stride, border).contiguous();
    fresco::Raster8 result(static_cast<int>(pooled.size(2)), static_cast<int>(pooled.size(1)));
    std::transform(pooled.data_ptr<float>(), pooled.data_ptr<float>() + pooled.numel(), result.values.begin(),
                   [](float v) { return static_cast<std::uint8_t>(v); });
    return result;
}

/// The pixels of a mask and those beside them.
fresco::Raster8 grown(const fresco::Raster8& mask)
{
    return largest(mask, 3, 1, 1);
}

/// Pixels of 2 x 2, one of which is in the mask.
fresco::Raster8 halved(const fresco::Raster8& mask)
{
    return largest(mask, 2, 2, 0);
}

/// Sets what is set in `other`, whose pixels are `times` x `times` of the mask's.
void add(fresco::Raster8& mask, const fresco::Raster8& other, int times)
{
    for (int y = 0; y < other.height * times; ++y)
        for (int x = 0; x < other.width * times; ++x)
            mask.at(x, y) |= other.at(x / times, y / times);
}

/// With a frame of one pixel, where the mask is what the border reflects.
fresco::Raster8 framed_as_reflected(const fresco::Raster8& mask)
{
    fresco::Raster8 result(mask.width + 2, mask.height + 2);
    const auto from = [](int i, int count) { return count == 1 ? 0 : i == 0 ? 1 : i == count + 1 ? count - 2 : i - 1; };
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
            result.at(x, y) = mask.at(from(x, mask.width), from(y, mask.height));
    return result;
}

}  // namespace

/// Pixels to compute of each convolution, if not all.
struct CpuEncoder::Needed
{
    std::vector<fresco::Raster8> responses;  ///< Pixels that the requested features depend on.
    std::vector<fresco::Raster8> gradients;  ///< Pixels of the input that the picture's gradient depends on.
};

/// State that the backward pass needs.
struct CpuEncoder::Tape : torch::CustomClassHolder
{
    struct Entry
    {
        MapsShape shape;       ///< Shape of the responses.
        torch::Tensor mask;    ///< As vgg19::Responses has it; undefined where `chosen` says enough.
        torch::Tensor chosen;  ///< Responses::chosen; only where they are pooled.
    };

    std::shared_ptr<const CpuEncoder> encoder;
    std::vector<std::size_t> wanted;
    std::optional<Needed> needed;  ///< Missing: everything.
    std::vector<Entry> entries;    ///< By convolution.
};

struct CpuEncoder::Function : torch::autograd::Function<CpuEncoder::Function>
{
    static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context, const torch::Tensor& picture,
                                                  const c10::intrusive_ptr<Tape>& tape)
    {
        context->set_materialize_grads(false);
        context->saved_data["tape"] = torch::IValue::make_capsule(tape);
        return tape->encoder->encode(picture, *tape, true);
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   const torch::autograd::variable_list& gradients)
    {
        const auto capsule = context->saved_data["tape"].toCapsule();
        const auto& tape = static_cast<const Tape&>(*capsule);
        return {tape.encoder->gradient(tape, gradients), torch::Tensor()};
    }
};

CpuEncoder::CpuEncoder(const std::vector<Convolution>& layers, const fresco::weights::Vgg19Input& input) : input_(input)
{
    for (const auto& convolution : layers)
    {
        auto layer = std::make_unique<Layer>();
        layer->weights = convolution.weights.to(at::kCPU, at::kFloat).contiguous();
        const auto bias = convolution.bias.to(at::kCPU, at::kFloat).contiguous();
        layer->bias.assign(values_of(bias).begin(), values_of(bias).end());
        layer->pooled = convolution.pooled;
        layers_.push_back(std::move(layer));
    }
}

bool CpuEncoder::takes(const torch::Tensor& picture, const std::vector<Convolution>& layers, std::size_t last)
{
    if (!picture.device().is_cpu() || picture.scalar_type() != at::kFloat || picture.dim() != 3)
        return false;
    std::int64_t smaller = std::min(picture.size(1), picture.size(2));
    for (std::size_t i = 0; i <= last; ++i)
    {
        smaller /= layers[i].pooled ? 2 : 1;
        if (layers[i].weights.size(0) % 16 != 0)
            return false;
    }
    return smaller > 0;
}

const Convolution3x3& CpuEncoder::forward(std::size_t layer) const
{
    auto& l = *layers_[layer];
    std::call_once(l.forward_once,
                   [&] { l.forward.emplace(values_of(l.weights), channels_of(l.weights, 0), channels_of(l.weights, 1)); });
    return *l.forward;
}

const Convolution3x3& CpuEncoder::backward(std::size_t layer) const
{
    auto& l = *layers_[layer];
    std::call_once(l.backward_once,
                   [&] {
                       l.backward.emplace(values_of(l.weights), channels_of(l.weights, 0), channels_of(l.weights, 1),
                                          Convolution3x3::Way::back);
                   });
    return *l.backward;
}

torch::Tensor CpuEncoder::network_input(const torch::Tensor& picture) const
{
    const auto planes = picture.contiguous();
    const MapsShape shape{static_cast<int>(planes.size(1)), static_cast<int>(planes.size(2)), forward(0).inputs()};
    auto maps = room_for(shape, at::kFloat).zero_();
    const auto channels = static_cast<std::size_t>(shape.channels);
    for (std::size_t channel = 0; channel < 3; ++channel)
    {
        const float* from = planes.data_ptr<float>() + (input_.bgr ? 2 - channel : channel) * shape.pixels();
        float* to = maps.data_ptr<float>() + channel;
        for (std::size_t i = 0; i < shape.pixels(); ++i)
            to[i * channels] = static_cast<float>((from[i] * input_.scale - input_.mean[channel]) / input_.deviation[channel]);
    }
    return maps;
}

torch::Tensor CpuEncoder::picture_gradient(GradientView gradient, MapsShape shape) const
{
    auto result = at::empty({3, shape.height, shape.width}, at::kFloat);
    const auto channels = static_cast<std::size_t>(shape.channels);
    const auto width = static_cast<std::size_t>(shape.width);
    for (std::size_t channel = 0; channel < 3; ++channel)
    {
        float* to = result.data_ptr<float>() + (input_.bgr ? 2 - channel : channel) * shape.pixels();
        const auto factor = static_cast<float>(input_.scale / input_.deviation[channel]);
        for (std::size_t y = 0; y < static_cast<std::size_t>(shape.height); ++y)
            for (std::size_t x = 0; x < width; ++x)
                to[y * width + x] = factor * gradient.values[y * gradient.row + x * channels + channel];
    }
    return result;
}

CpuEncoder::Needed CpuEncoder::needed(const fresco::ReadPixels& read, const std::vector<std::size_t>& wanted) const
{
    const std::size_t count = wanted.back() + 1;
    std::vector<fresco::Raster8> own;  // The pixels, on each convolution's grid.
    for (std::size_t i = 0; i < count; ++i)
        own.push_back(i == 0 ? read.features : layers_[i]->pooled ? halved(own.back()) : own.back());
    Needed result{std::vector<fresco::Raster8>(count), {}};
    for (std::size_t i = count; i-- > 0;)
    {
        auto& responses = result.responses[i];
        responses = fresco::Raster8(own[i].width, own[i].height);
        if (std::ranges::find(wanted, i) != wanted.end())
            add(responses, own[i], 1);
        if (i + 1 < count)
            add(responses, grown(result.responses[i + 1]), layers_[i + 1]->pooled ? 2 : 1);
    }
    fresco::Raster8 seen = read.gradient;
    for (std::size_t i = 0; i < count; ++i)
    {
        if (layers_[i]->pooled)
            seen = halved(seen);
        auto& gradients = result.gradients.emplace_back(grown(result.responses[i]));
        std::ranges::transform(gradients.values, seen.values, gradients.values.begin(),
                               [](auto a, auto b) { return static_cast<std::uint8_t>(a & b); });
        seen = grown(seen);
    }
    return result;
}

std::vector<torch::Tensor> CpuEncoder::encode(const torch::Tensor& picture, const std::vector<std::size_t>& wanted,
                                              const fresco::ReadPixels* read) const
{
    auto tape = c10::make_intrusive<Tape>();
    tape->encoder = shared_from_this();
    tape->wanted = wanted;
    if (read != nullptr)
        tape->needed = needed(*read, wanted);
    if (!picture.requires_grad() || !at::GradMode::is_enabled())
        return encode(picture, *tape, false);
    return Function::apply(picture, tape);
}

std::vector<torch::Tensor> CpuEncoder::encode(const torch::Tensor& picture, Tape& tape, bool goes_back) const
{
    const auto& wanted = tape.wanted;
    std::vector<torch::Tensor> result;
    auto maps = network_input(picture);
    MapsShape shape{static_cast<int>(maps.size(1)), static_cast<int>(maps.size(2)), static_cast<int>(maps.size(0))};
    for (std::size_t i = 0; result.size() < wanted.size(); ++i)
    {
        const auto& convolution = forward(i);
        const MapsShape in_shape = shape;
        shape.channels = convolution.outputs();
        const bool is_wanted = wanted[result.size()] == i;
        const bool is_pooled = result.size() + (is_wanted ? 1 : 0) < wanted.size() && layers_[i + 1]->pooled;
        Tape::Entry entry;
        entry.shape = shape;
        torch::Tensor out;
        torch::Tensor pooled;
        Responses responses;
        if (is_wanted || !is_pooled)
        {
            out = room_for(shape, at::kFloat);
            responses.maps = out.data_ptr<float>();
        }
        if (is_pooled)
        {
            pooled = room_for(shape.halved(), at::kFloat);
            responses.pooled = pooled.data_ptr<float>();
        }
        if (goes_back && is_pooled)
        {
            entry.chosen = room_for(shape.halved(), at::kByte);
            responses.chosen = entry.chosen.data_ptr<std::uint8_t>();
        }
        if (goes_back && (is_wanted || !entry.chosen.defined()))
        {
            entry.mask = room_for(shape, at::kByte);
            responses.masks = entry.mask.data_ptr<std::uint8_t>();
        }
        convolution.rectified(maps.data_ptr<float>(), in_shape, border_of(input_.padding), layers_[i]->bias.data(), responses,
                              on_all_threads, tape.needed ? tape.needed->responses[i].values.data() : nullptr);
        if (is_wanted)
            result.push_back(out);
        if (is_pooled)
            shape = shape.halved();
        maps = is_pooled ? pooled : out;
        if (goes_back)
            tape.entries.push_back(std::move(entry));
    }
    return result;
}

torch::Tensor CpuEncoder::own_gradient(const Tape& tape, const std::vector<torch::Tensor>& of_wanted, std::size_t layer)
{
    const auto place = std::find(tape.wanted.begin(), tape.wanted.end(), layer) - tape.wanted.begin();
    if (place == std::ssize(tape.wanted) || !of_wanted[static_cast<std::size_t>(place)].defined())
        return {};
    const auto& given = of_wanted[static_cast<std::size_t>(place)];
    if (given.permute({1, 2, 0}).is_contiguous())
        return given;
    const auto planes = given.contiguous();
    const auto& shape = tape.entries[layer].shape;
    auto result = room_for(shape, at::kFloat);
    from_planes(planes.data_ptr<float>(), shape, result.data_ptr<float>(), on_all_threads);
    return result;
}

torch::Tensor CpuEncoder::gradient(const Tape& tape, const std::vector<torch::Tensor>& of_wanted) const
{
    const bool reflects = border_of(input_.padding) == Border::reflect;
    torch::Tensor framed;  // Gradients of the next convolution's input, with a frame where its border was reflected.
    GradientView of_next;
    for (std::size_t i = tape.entries.size(); i-- > 0;)
    {
        const auto& entry = tape.entries[i];
        const auto own = own_gradient(tape, of_wanted, i);
        const auto bytes = [](const torch::Tensor& tensor)
        { return tensor.defined() ? tensor.data_ptr<std::uint8_t>() : nullptr; };
        const ResponseGradient gradient{.own = own.defined() ? own.data_ptr<float>() : nullptr,
                                        .of_next = of_next,
                                        .masks = bytes(entry.mask),
                                        .chosen = bytes(entry.chosen)};
        const auto& convolution = backward(i);
        const int frame = reflects ? 1 : 0;
        const MapsShape shape{entry.shape.height + 2 * frame, entry.shape.width + 2 * frame, convolution.outputs()};
        const auto of_input = room_for(shape, at::kFloat);
        const auto needed = !tape.needed ? fresco::Raster8()
                            : reflects   ? framed_as_reflected(tape.needed->gradients[i])
                                         : tape.needed->gradients[i];
        convolution.back(gradient, entry.shape, frame, of_input.data_ptr<float>(), on_all_threads,
                         needed.empty() ? nullptr : needed.values.data());
        framed = of_input;
        of_next = reflects ? folded(framed.data_ptr<float>(), entry.shape.height, entry.shape.width, shape.channels)
                           : GradientView{framed.data_ptr<float>(),
                                          static_cast<std::size_t>(shape.width) * static_cast<std::size_t>(shape.channels)};
    }
    return picture_gradient(of_next, {tape.entries[0].shape.height, tape.entries[0].shape.width, backward(0).outputs()});
}

}  // namespace vgg19
