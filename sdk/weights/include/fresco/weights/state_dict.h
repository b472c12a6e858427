#pragma once

/// \file Named tensors in files, read as bytes: safetensors, and the state dicts that PyTorch saves. Nothing in a file is ever
/// executed, and no size that a file claims is believed before it is compared with the bytes that are there.

#include <fresco/option_declaration.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fresco::weights
{

/// Safetensors and state dicts of PyTorch.
std::vector<FileFormat> file_formats();

/// In descending order of size, so that tensors written in this order are aligned.
enum class ElementType
{
    float64,
    int64,
    float32,
    int32,
    float16,
    bfloat16,
    int16,
    uint8,
    int8,
    boolean
};
std::size_t size_of(ElementType type);
bool is_floating(ElementType type);
/// As safetensors name it: "F32".
std::string_view name_of(ElementType type);

/// A tensor whose elements lie in row-major order, little-endian, not aligned, somewhere in the bytes that were parsed.
struct TensorView
{
    std::string name;
    ElementType type = ElementType::float32;
    std::vector<std::size_t> shape;
    std::span<const std::byte> bytes;  ///< Product of the shape times size_of(type).

    std::size_t count() const { return bytes.size() / size_of(type); }
};
/// "64 x 3 x 3 x 3".
std::string shape_text(std::span<const std::size_t> shape);
/// Its elements in single precision. Throws Error naming `source` and the tensor where it does not hold floating-point numbers,
/// or where one of them is not finite.
std::vector<float> to_float32(const TensorView& tensor, std::string_view source);

enum class Form
{
    safetensors,
    legacy_pickle,  ///< torch.save before 1.6: pickles, then the storages.
    zip_pickle      ///< torch.save since 1.6.
};
/// "safetensors", "legacy pickle", "zip pickle".
std::string_view name_of(Form form);

struct StateDict
{
    Form form = Form::safetensors;
    std::vector<TensorView> tensors;              ///< Names are unique.
    std::map<std::string, std::string> metadata;  ///< Metadata of safetensors.

    /// nullptr without one.
    const TensorView* find(std::string_view name) const;
};

/// Tells the form by the first bytes and reads it. Views point into `bytes`. Throws Error naming `source` and the offset.
StateDict parse_state_dict(std::span<const std::byte> bytes, std::string_view source);

/// A file and what is in it. May be moved, not copied: the views point into `bytes`.
struct WeightsFile
{
    std::vector<std::byte> bytes;
    StateDict contents;

    WeightsFile() = default;
    WeightsFile(WeightsFile&&) = default;
    WeightsFile& operator=(WeightsFile&&) = default;
};
/// At most 4 GiB. Throws MissingInput if it cannot be opened, Error for what is wrong with it.
WeightsFile read_weights(const std::filesystem::path& file);

/// The safetensors form. Strict: a header of at most 4 MiB, offsets without overlap or gap, shapes that fit.
StateDict parse_safetensors(std::span<const std::byte> bytes, std::string_view source);
/// Tensors in the order of their types, then as given. The same tensors give the same bytes. Throws std::invalid_argument for a
/// tensor named __metadata__ or whose bytes do not fit its shape.
std::vector<std::byte> to_safetensors(std::span<const TensorView> tensors, const std::map<std::string, std::string>& metadata);

/// A state dict that torch.save wrote before PyTorch 1.6: four pickles (magic number, protocol, byte order, the dict), the list
/// of storages, and each storage's length and elements. Only tensors whose elements lie in row-major order.
StateDict parse_legacy_pickle(std::span<const std::byte> bytes, std::string_view source);
/// A state dict in a zip archive (torch.save since PyTorch 1.6): stored entries only, checksums compared.
StateDict parse_zip_pickle(std::span<const std::byte> bytes, std::string_view source);

/// Writes what to_safetensors() gives, from where the tensors lie: no copy of them is made. Whole or not at all, as write_file.
void write_safetensors(const std::filesystem::path& file, std::span<const TensorView> tensors,
                       const std::map<std::string, std::string>& metadata);

}  // namespace fresco::weights
