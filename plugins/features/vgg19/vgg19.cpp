#include "vgg19.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <torch/csrc/autograd/autograd.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

namespace vgg19
{
namespace
{

/// The row or column of the framed maps that each of the two outer ones is the picture of.
struct Sources
{
    std::int64_t first;
    std::int64_t last;
};

Sources sources(std::int64_t count)
{
    // A side of one pixel has nothing to reflect: that pixel goes on.
    return count > 1 ? Sources{2, count - 1} : Sources{1, 1};
}

/// 1 x C x H x W maps with one pixel more on each side: reflected, or repeated where a side has only one pixel. Of any type, on
/// any device; channels are innermost in memory before and after, unlike with libtorch's own on CUDA. Differentiable once.
struct Reflected : torch::autograd::Function<Reflected>
{
    static at::Tensor forward(torch::autograd::AutogradContext*, const at::Tensor& maps)
    {
        const auto height = maps.size(2);
        const auto width = maps.size(3);
        auto framed =
            at::empty({maps.size(0), maps.size(1), height + 2, width + 2}, maps.options(), at::MemoryFormat::ChannelsLast);
        framed.slice(2, 1, height + 1).slice(3, 1, width + 1).copy_(maps);
        for (const std::int64_t dimension : {2, 3})
        {
            const auto count = maps.size(dimension);
            const auto from = sources(count);
            framed.select(dimension, 0).copy_(framed.select(dimension, from.first));
            framed.select(dimension, count + 1).copy_(framed.select(dimension, from.last));
        }
        return framed;
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext*, torch::autograd::variable_list gradients)
    {
        auto framed = gradients[0].clone(at::MemoryFormat::ChannelsLast);
        const auto height = framed.size(2) - 2;
        const auto width = framed.size(3) - 2;
        for (const std::int64_t dimension : {3, 2})
        {
            const auto count = framed.size(dimension) - 2;
            const auto from = sources(count);
            framed.select(dimension, from.first).add_(framed.select(dimension, 0));
            framed.select(dimension, from.last).add_(framed.select(dimension, count + 1));
        }
        return {framed.slice(2, 1, height + 1).slice(3, 1, width + 1)};
    }
};

using fresco::weights::Vgg19Padding;

torch::Tensor to_tensor(const fresco::weights::TensorView& view, std::string_view source)
{
    const auto values = fresco::weights::to_float32(view, source);
    const std::vector<std::int64_t> shape(view.shape.begin(), view.shape.end());
    auto tensor = at::empty(shape, at::kFloat);
    std::copy(values.begin(), values.end(), tensor.data_ptr<float>());
    return tensor;
}

/// Maps, or a convolution's weights as its maps have them: else libtorch turns them each time.
torch::Tensor laid_out(const torch::Tensor& values)
{
    return values.contiguous(at::MemoryFormat::ChannelsLast);
}

torch::Tensor pooled(const torch::Tensor& maps)
{
    const auto height = maps.size(2) / 2;
    const auto width = maps.size(3) / 2;
    if (height == 0 || width == 0)
        return maps.new_empty({1, maps.size(1), height, width});
    return at::max_pool2d(maps, {2, 2});
}

/// Filters with their rows and columns reversed and their channels exchanged.
torch::Tensor turned(const torch::Tensor& filters)
{
    return filters.flip({2, 3}).transpose(0, 1);
}

torch::Tensor convolved(const torch::Tensor& maps, const torch::Tensor& filters, const torch::Tensor& bias, std::int64_t padding,
                        bool tf32)
{
    return at::_convolution(maps, filters, bias, {1, 1}, {padding, padding}, {1, 1}, false, {0, 0}, 1, false, false, true, tf32);
}

/// Lets convolutions by cuDNN round the factors of float32 products, or not, while it lives.
class Tf32
{
  public:
    explicit Tf32(bool allowed) { at::globalContext().setAllowTF32CuDNN(allowed); }
    ~Tf32() { at::globalContext().setAllowTF32CuDNN(before_); }
    Tf32(const Tf32&) = delete;
    Tf32& operator=(const Tf32&) = delete;

  private:
    bool before_ = at::globalContext().allowTF32CuDNN();
};

torch::Tensor rectified(const torch::Tensor& maps, const torch::Tensor& filters, const torch::Tensor& bias, std::int64_t padding,
                        bool tf32)
{
    if (!maps.is_cuda())
        return convolved(maps, filters, bias, padding, tf32).relu_();
    // Bias and rectifier in the same pass, which else cost as much as the convolution. This operator has no argument for tf32.
    const Tf32 as_wanted(tf32);
    return at::cudnn_convolution_relu(maps, filters, bias, {1, 1}, {padding, padding}, {1, 1}, 1);
}

/// Convolution and rectifier of frozen filters. Its way back is a convolution too, with the filters turned: in float32, cuDNN's
/// own way back takes up to eight times as long for large maps of few channels.
struct Rectified : torch::autograd::Function<Rectified>
{
    static at::Tensor forward(torch::autograd::AutogradContext* context, const at::Tensor& maps, const at::Tensor& filters,
                              const at::Tensor& turned, const at::Tensor& bias, std::int64_t padding, bool tf32)
    {
        const auto result = rectified(maps, filters, bias, padding, tf32);
        context->save_for_backward({result, turned});
        context->saved_data["padding"] = 2 - padding;
        context->saved_data["tf32"] = tf32;
        return result;
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto saved = context->get_saved_variables();
        const auto passed = at::threshold_backward(gradients[0], saved[0], 0);
        const auto back =
            convolved(passed, saved[1], {}, context->saved_data["padding"].toInt(), context->saved_data["tf32"].toBool());
        return {back, {}, {}, {}, {}, {}};
    }
};

}  // namespace

std::vector<Convolution> convolutions(const fresco::weights::Vgg19Weights& weights, std::string_view source)
{
    std::vector<Convolution> result;
    for (const auto& layer : weights.layers)
        result.push_back({"relu" + layer.name, to_tensor(layer.weight, source), to_tensor(layer.bias, source), layer.pooled});
    return result;
}

Vgg19::Vgg19(std::vector<Convolution> layers, const fresco::weights::Vgg19Input& input)
    : convolutions_(std::move(layers)), on_cpu_(std::make_shared<CpuEncoder>(convolutions_, input)), input_(input)
{
    const auto deviation = at::tensor(input_.deviation, at::kDouble).view({3, 1, 1});
    exact_input_terms_ = {input_.scale / deviation, at::tensor(input_.mean, at::kDouble).view({3, 1, 1}) / -deviation};
    input_terms_ = {exact_input_terms_.factor.to(at::kFloat), exact_input_terms_.offset.to(at::kFloat)};
}

void Vgg19::move_to(const torch::Device& device)
{
    for (auto& convolution : convolutions_)
    {
        convolution.weights = convolution.weights.to(device);
        convolution.bias = convolution.bias.to(device);
    }
    input_terms_ = {input_terms_.factor.to(device), input_terms_.offset.to(device)};
    get_ready();
}

void Vgg19::set_tf32(bool tf32)
{
    tf32_ = tf32;
    get_ready();
}

void Vgg19::get_ready()
{
    ready_.clear();
    // The CPU has its own encoder.
    if (!tf32_ && convolutions_.front().weights.device().is_cpu())
        return;
    std::vector<Filters> ready;
    for (std::size_t number = 0; number < convolutions_.size(); ++number)
        ready.push_back(filters(number, convolutions_[number].weights.options().dtype(at::kFloat)));
    ready_ = std::move(ready);
}

Vgg19::Filters Vgg19::filters(std::size_t number, const torch::TensorOptions& options) const
{
    if (!ready_.empty() && ready_[number].weights.device() == options.device() &&
        ready_[number].weights.scalar_type() == c10::typeMetaToScalarType(options.dtype()))
        return ready_[number];
    const auto& convolution = convolutions_[number];
    const auto weights = convolution.weights.to(options);
    return {laid_out(weights), laid_out(turned(weights)), convolution.bias.to(options)};
}

std::vector<fresco::FeatureLayer> Vgg19::layers() const
{
    std::vector<fresco::FeatureLayer> result;
    int stride = 1;
    int margin = 0;
    for (const auto& convolution : convolutions_)
    {
        if (convolution.pooled)
            stride *= 2;
        margin += stride;
        fresco::FeatureLayer layer;
        layer.name = convolution.layer;
        layer.channels = static_cast<int>(convolution.weights.size(0));
        layer.stride = stride;
        layer.margin_px = margin;
        layer.style = convolution.layer.ends_with("_1");
        layer.content = convolution.layer == "relu4_2";
        result.push_back(layer);
    }
    const bool has_content = std::any_of(result.begin(), result.end(), [](const auto& layer) { return layer.content; });
    if (!has_content && !result.empty())
        result.back().content = true;
    return result;
}

torch::Tensor Vgg19::network_input(const torch::Tensor& picture) const
{
    const auto channels = input_.bgr ? picture.flip(0) : picture;
    const auto& [factor, offset] = picture.scalar_type() == at::kFloat ? input_terms_ : exact_input_terms_;
    return at::addcmul(offset.to(picture.options()), channels, factor.to(picture.options())).unsqueeze(0);
}

std::vector<torch::Tensor> Vgg19::encode(const torch::Tensor& picture, const std::vector<std::string>& names,
                                         const fresco::ReadPixels* read) const
{
    std::vector<std::size_t> wanted;
    for (std::size_t i = 0; i < convolutions_.size(); ++i)
        if (std::find(names.begin(), names.end(), convolutions_[i].layer) != names.end())
            wanted.push_back(i);
    if (wanted.empty() || !CpuEncoder::takes(picture, convolutions_, wanted.back()))
        return encode_generally(picture, names);
    const auto maps = on_cpu_->encode(picture, wanted, read);
    std::vector<torch::Tensor> result;
    for (const auto& name : names)
        for (std::size_t i = 0; i < wanted.size(); ++i)
            if (convolutions_[wanted[i]].layer == name)
                result.push_back(maps[i]);
    return result;
}

std::vector<torch::Tensor> Vgg19::encode_generally(const torch::Tensor& picture, const std::vector<std::string>& names) const
{
    std::vector<torch::Tensor> result(names.size());
    std::size_t missing = names.size();
    auto maps = laid_out(network_input(picture));
    for (std::size_t number = 0; number < convolutions_.size() && missing > 0; ++number)
    {
        if (convolutions_[number].pooled)
            maps = pooled(maps);
        maps = responses(number, maps);
        for (std::size_t i = 0; i < names.size(); ++i)
            if (names[i] == convolutions_[number].layer)
            {
                result[i] = maps.squeeze(0);
                --missing;
            }
    }
    return result;
}

torch::Tensor Vgg19::responses(std::size_t number, const torch::Tensor& input) const
{
    if (input.size(2) == 0 || input.size(3) == 0)
        return input.new_empty({1, convolutions_[number].weights.size(0), input.size(2), input.size(3)});
    const bool reflect = input_.padding == Vgg19Padding::reflect;
    const auto bordered = reflect ? Reflected::apply(input) : input;
    const auto with = filters(number, input.options());
    return Rectified::apply(bordered, with.weights, with.turned, with.bias, reflect ? 0 : 1, tf32_);
}

namespace
{

/// Maps of 1 x C x H x W as C x (H W), in the same memory.
torch::Tensor columns_of(const torch::Tensor& maps)
{
    return maps.squeeze(0).flatten(1);
}

void clear(const torch::Tensor& maps, const torch::Tensor& cells)
{
    columns_of(maps).index_fill_(1, cells, 0);
}

}  // namespace

/// A sheet on its way through the network, and what the way back needs of it.
struct Vgg19::SheetTape : torch::CustomClassHolder
{
    struct Layer
    {
        Filters filters;
        bool pooled = false;
        torch::Tensor maps;    ///< Its responses.
        torch::Tensor chosen;  ///< Positions that pooling took from the layer before.
    };

    std::vector<Layer> layers;
    std::vector<std::size_t> wanted;  ///< May name a layer several times.
    fresco::Sheet sheet;
    InputTerms terms;  ///< 3 numbers each.
    bool bgr = false;
    bool tf32 = false;
    std::array<std::int64_t, 2> size{};  ///< Height and width of the picture.
    bool goes_back = false;

    std::vector<torch::Tensor> encode(const torch::Tensor& picture)
    {
        const auto colors = picture.flatten(1).t().index_select(0, sheet.pixels);
        const auto values = at::addcmul(terms.offset, bgr ? colors.flip(1) : colors, terms.factor);
        auto maps = at::zeros({sheet.height * sheet.width, 3}, values.options())
                        .index_copy_(0, sheet.places, values)
                        .view({1, sheet.height, sheet.width, 3})
                        .permute({0, 3, 1, 2});
        std::vector<torch::Tensor> results(wanted.size());
        int stride = 1;
        for (std::size_t number = 0; number < layers.size(); ++number)
        {
            auto& layer = layers[number];
            if (layer.pooled)
            {
                stride *= 2;
                std::tie(maps, layer.chosen) = at::max_pool2d_with_indices(maps, {2, 2});
            }
            // Beyond a box lie zeros, as beyond a picture, in place of what spilled over. The input has no other values there.
            if (number > 0)
                clear(maps, sheet.borders.at(stride));
            maps = rectified(maps, layer.filters.weights, layer.filters.bias, 1, tf32);
            if (goes_back)
                layer.maps = maps;
            const auto columns = columns_of(maps);
            for (std::size_t i = 0; i < wanted.size(); ++i)
                if (wanted[i] == number)
                    results[i] = columns.t().is_contiguous() ? columns.t().index_select(0, sheet.cells.at(stride)).t()
                                                             : columns.index_select(1, sheet.cells.at(stride));
        }
        return results;
    }

    torch::Tensor gradient(const std::vector<torch::Tensor>& of_wanted)
    {
        int stride = 1;
        for (const auto& layer : layers)
            stride *= layer.pooled ? 2 : 1;
        auto gradient = at::zeros_like(layers.back().maps);
        for (std::size_t number = layers.size(); number-- > 0;)
        {
            auto& layer = layers[number];
            for (std::size_t i = 0; i < wanted.size(); ++i)
                if (wanted[i] == number && of_wanted[i].defined())
                    columns_of(gradient).index_add_(1, sheet.cells.at(stride), of_wanted[i]);
            gradient = at::threshold_backward(gradient, layer.maps, 0);
            gradient = convolved(gradient, layer.filters.turned, {}, 1, tf32);
            layer.maps.reset();
            if (!layer.pooled)
                continue;
            // Else the pixels of an odd last row or column, which pooling leaves out, would take what spilled over.
            clear(gradient, sheet.borders.at(stride));
            gradient = at::max_pool2d_with_indices_backward(gradient, layers[number - 1].maps, {2, 2}, {2, 2}, {0, 0}, {1, 1},
                                                            false, layer.chosen);
            stride /= 2;
        }
        const auto values = columns_of(gradient).t().index_select(0, sheet.places);
        const auto scaled = values * terms.factor;
        const auto colors = bgr ? scaled.flip(1) : scaled;
        return at::zeros({size[0] * size[1], 3}, colors.options())
            .index_add_(0, sheet.pixels, colors)
            .t()
            .view({3, size[0], size[1]});
    }
};

struct Vgg19::SheetFunction : torch::autograd::Function<SheetFunction>
{
    static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context, const torch::Tensor& picture,
                                                  const c10::intrusive_ptr<SheetTape>& tape)
    {
        context->set_materialize_grads(false);
        context->saved_data["tape"] = torch::IValue::make_capsule(tape);
        return tape->encode(picture);
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   const torch::autograd::variable_list& gradients)
    {
        return {static_cast<SheetTape&>(*context->saved_data["tape"].toCapsule()).gradient(gradients), torch::Tensor()};
    }
};

std::vector<torch::Tensor> Vgg19::encode_sheet(const torch::Tensor& picture, const std::vector<std::string>& names,
                                               const fresco::Sheet& sheet) const
{
    auto tape = c10::make_intrusive<SheetTape>();
    for (const auto& name : names)
        for (std::size_t number = 0; number < convolutions_.size(); ++number)
            if (convolutions_[number].layer == name)
                tape->wanted.push_back(number);
    for (std::size_t number = 0; number <= std::ranges::max(tape->wanted); ++number)
        tape->layers.push_back({filters(number, picture.options()), convolutions_[number].pooled, {}, {}});
    const auto& terms = picture.scalar_type() == at::kFloat ? input_terms_ : exact_input_terms_;
    tape->terms = {terms.factor.to(picture.options()).flatten(), terms.offset.to(picture.options()).flatten()};
    tape->sheet = sheet;
    tape->bgr = input_.bgr;
    tape->tf32 = tf32_;
    tape->size = {picture.size(1), picture.size(2)};
    tape->goes_back = at::GradMode::is_enabled() && picture.requires_grad();
    return SheetFunction::apply(picture, tape);
}

namespace
{

/// By the losses that a run of Gatys' method with the original weights printed; layers in the network's order.
constexpr std::array<std::pair<std::string_view, double>, 6> raw_means{
    {{"relu1_1", 21}, {"relu2_1", 83}, {"relu3_1", 76}, {"relu4_1", 320}, {"relu4_2", 390}, {"relu5_1", 27}}};

}  // namespace

double raw_mean(std::string_view layer)
{
    double mean = 0;
    for (const auto& [name, value] : raw_means)
        if (name <= layer)
            mean = value;
    return mean;
}

namespace
{

/// The network whose input is BGR in 0..255 minus its mean color and whose layers answer as those of `network` do: order of
/// channels, scale, mean and deviation are folded into the first convolution. A border of zeros stays the mean color.
Vgg19 folded(const Vgg19& network)
{
    const auto& from = network.input();
    fresco::weights::Vgg19Input to;
    to.bgr = true;
    to.scale = 255;
    to.padding = from.padding;
    auto layers = network.convolutions();
    const auto old_weights = layers.front().weights.to(at::kDouble);
    auto new_weights = at::empty_like(old_weights);
    for (std::size_t blue_first = 0; blue_first < 3; ++blue_first)
    {
        const std::size_t channel = from.bgr ? blue_first : 2 - blue_first;
        // x_old = (scale · c - mean) / deviation and x_new = 255 · c - 255 · mean / scale, so x_old = x_new · scale / (255 ·
        // deviation).
        to.mean[blue_first] = from.mean[channel] * 255 / from.scale;
        new_weights.select(1, static_cast<std::int64_t>(blue_first))
            .copy_(old_weights.select(1, static_cast<std::int64_t>(channel)) * (from.scale / (255 * from.deviation[channel])));
    }
    layers.front().weights = new_weights.to(at::kFloat);
    return {std::move(layers), to};
}

/// The mean activation of each layer over all filters and places, averaged over `pictures` (RGB in [0,1], 3 x H x W). In a fixed
/// order.
std::vector<double> mean_activations(const Vgg19& network, const std::vector<torch::Tensor>& pictures)
{
    const at::NoGradGuard no_gradient;
    std::vector<std::string> names;
    for (const auto& layer : network.convolutions())
        names.push_back(layer.layer);
    std::vector<double> means(names.size(), 0.0);
    for (const auto& picture : pictures)
    {
        const auto maps = network.encode(picture, names);
        for (std::size_t i = 0; i < maps.size(); ++i)
            means[i] += fresco::ordered_mean(maps[i].to(at::kDouble)).item<double>() / static_cast<double>(pictures.size());
    }
    return means;
}

}  // namespace

Rescaled rescaled(const Vgg19& network, const std::vector<torch::Tensor>& pictures)
{
    if (pictures.empty())
        throw fresco::Error("features.vgg19: these weights are rescaled by the style and the frames, but there is no picture; "
                            "use raw weights");
    const Vgg19 common = folded(network);
    const auto means = mean_activations(common, pictures);
    // Exact, since rectifier, pooling and padding commute with a factor: weights are multiplied by their layer's factor and
    // divided by that of the layer that they read.
    auto layers = common.convolutions();
    double before = 1;
    for (std::size_t i = 0; i < means.size(); ++i)
    {
        const std::string& layer = layers[i].layer;
        if (!(means[i] > 0) || !std::isfinite(means[i]))
            throw fresco::Error(
                "features.vgg19: layer " + layer +
                " is zero on the style and on all frames, so it cannot be rescaled; use the weights of a trained VGG-19");
        const double factor = raw_mean(layer) / means[i];
        layers[i].weights = (layers[i].weights.to(at::kDouble) * (factor / before)).to(at::kFloat);
        layers[i].bias = (layers[i].bias.to(at::kDouble) * factor).to(at::kFloat);
        before = factor;
    }
    return {{std::move(layers), common.input()}, means};
}

}  // namespace vgg19
