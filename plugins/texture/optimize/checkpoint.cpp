#include "checkpoint.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/torch/tensor.h>
#include <fresco/torch/tensor_memory.h>

#include <ATen/ops/empty.h>

#include <algorithm>
#include <fmt/format.h>
#include <span>
#include <string_view>
#include <system_error>

namespace fresco::optimize
{
namespace
{

const std::string parameter_prefix = "parameter/";
const std::string rule_prefix = "rule/";
const std::string loss_prefix = "loss/";
constexpr const char* seen_name = "seen";
constexpr const char* held_out_name = "held_out";
constexpr const char* checksum_name = "checksum";
constexpr const char* form = "fresco texture.optimize 4";

torch::Tensor to_bytes(const Raster8& raster)
{
    auto tensor = at::empty({raster.height, raster.width}, at::kByte);
    std::copy(raster.values.begin(), raster.values.end(), tensor.data_ptr<std::uint8_t>());
    return tensor;
}

Raster8 from_bytes(const torch::Tensor& tensor)
{
    Raster8 raster(static_cast<int>(tensor.size(1)), static_cast<int>(tensor.size(0)));
    std::copy_n(tensor.data_ptr<std::uint8_t>(), raster.values.size(), raster.values.begin());
    return raster;
}

/// Rows of the step, the loss and its parts.
torch::Tensor to_tensor(const std::vector<HeldOutLoss>& history)
{
    const std::size_t columns = history.empty() ? 2 : 2 + history[0].parts.size();
    auto tensor = at::empty({std::ssize(history), static_cast<std::int64_t>(columns)}, at::kDouble);
    double* value = tensor.data_ptr<double>();
    for (const auto& entry : history)
    {
        *value++ = static_cast<double>(entry.step);
        *value++ = entry.loss;
        value = std::copy(entry.parts.begin(), entry.parts.end(), value);
    }
    return tensor;
}

std::vector<HeldOutLoss> to_history(const torch::Tensor& tensor)
{
    std::vector<HeldOutLoss> history;
    for (std::int64_t i = 0; i < tensor.size(0); ++i)
    {
        const double* row = tensor.data_ptr<double>() + i * tensor.size(1);
        history.push_back({static_cast<std::int64_t>(row[0]), row[1], std::vector<double>(row + 2, row + tensor.size(1))});
    }
    return history;
}

/// Checksum of everything but itself. The tensors are contiguous and on the CPU.
std::string checksum_of(const SafeTensors& contents)
{
    std::string all;
    const auto add = [&all](const std::string& text) { all += fmt::format("{}:{}", text.size(), text); };
    for (const auto& [name, text] : contents.metadata)
        if (name != checksum_name)
        {
            add(name);
            add(text);
        }
    for (const auto& [name, tensor] : contents.tensors)
    {
        add(name);
        add(std::to_string(static_cast<int>(tensor.scalar_type())));
        for (const std::int64_t size : tensor.sizes())
            add(std::to_string(size));
        add(content_hash(std::span(static_cast<const std::byte*>(tensor.data_ptr()), tensor.nbytes())));
    }
    return content_hash(all);
}

}  // namespace

Checkpoint Checkpoint::copied() const
{
    Checkpoint result = *this;
    const auto copy = [](TensorMap& tensors)
    {
        for (auto& [name, tensor] : tensors)
            tensor = tensor.clone();
    };
    copy(result.parameters);
    copy(result.rule);
    for (auto& [name, tensors] : result.losses)
        copy(tensors);
    return result;
}

void Checkpoint::write(const std::filesystem::path& file) const
{
    SafeTensors contents;
    contents.metadata = {{"form", form}, {"step", std::to_string(step)}, {"rollbacks", std::to_string(rollbacks)}};
    for (const auto& [name, tensor] : parameters)
        contents.tensors.emplace(parameter_prefix + name, tensor);
    for (const auto& [name, tensor] : rule)
        contents.tensors.emplace(rule_prefix + name, tensor);
    for (const auto& [loss, state] : losses)
        for (const auto& [name, tensor] : state)
            contents.tensors.emplace(loss_prefix + loss + "/" + name, tensor);
    contents.tensors.emplace(seen_name, to_bytes(seen));
    contents.tensors.emplace(held_out_name, to_tensor(held_out));
    for (auto& [name, tensor] : contents.tensors)
        tensor = tensor.detach().to(at::kCPU).contiguous();
    contents.metadata[checksum_name] = checksum_of(contents);
    write_safetensors(file, contents);
}

std::optional<Checkpoint> Checkpoint::read(const std::filesystem::path& file)
{
    if (!path_status(file))
        return std::nullopt;
    auto contents = read_safetensors(file);
    Checkpoint result;
    if (contents.metadata["form"] != form)
        throw Error(file.string() + ": not a checkpoint of this version; remove the checkpoint folder");
    if (contents.metadata[checksum_name] != checksum_of(contents))
        throw Error(file.string() + ": is damaged: its bytes do not fit its checksum");
    result.step = std::stoll(contents.metadata.at("step"));
    result.rollbacks = std::stoll(contents.metadata.at("rollbacks"));
    for (auto& [name, tensor] : contents.tensors)
    {
        const auto slash = name.find('/', loss_prefix.size());
        if (name.starts_with(parameter_prefix))
            result.parameters.emplace(name.substr(parameter_prefix.size()), tensor);
        else if (name.starts_with(rule_prefix))
            result.rule.emplace(name.substr(rule_prefix.size()), tensor);
        else if (name.starts_with(loss_prefix) && slash != std::string::npos)
            result.losses[name.substr(loss_prefix.size(), slash - loss_prefix.size())].emplace(name.substr(slash + 1), tensor);
        else if (name == seen_name)
            result.seen = from_bytes(tensor);
        else if (name == held_out_name)
            result.held_out = to_history(tensor);
    }
    return result;
}

void Checkpoint::restore(std::vector<TextureParameter>& into, OptimizerRule& into_rule,
                         const std::map<std::string, std::shared_ptr<Loss>>& into_losses) const
{
    for (auto& parameter : into)
        // In place: views that exist already look into this memory.
        write_values(parameters.at(parameter.name), parameter.values);
    into_rule.restore(rule);
    for (const auto& [name, loss] : into_losses)
    {
        const auto found = losses.find(name);
        loss->restore(found == losses.end() ? TensorMap{} : found->second);
    }
}

namespace
{

/// Does nothing before the first one. Throws Error: a checkpoint that kept its old name would count as a newer one.
void rename_if_there(const std::filesystem::path& from, const std::filesystem::path& to)
{
    std::error_code error;
    std::filesystem::rename(from, to, error);
    if (error && error != std::errc::no_such_file_or_directory)
        throw Error(from.string() + ": cannot be renamed to " + to.filename().string() + ": " + error.message());
}

bool used(const std::filesystem::path& file, std::int64_t before, const CheckpointFolder::Use& use, RunContext& run)
{
    try
    {
        const auto checkpoint = Checkpoint::read(file);
        if (!checkpoint || checkpoint->step >= before)
            return false;
        use(*checkpoint);
        return true;
    }
    catch (const Error& error)
    {
        run.warning(std::string("the checkpoint cannot be used: ") + error.what());
        return false;
    }
}

}  // namespace

CheckpointFolder::Used CheckpointFolder::use_latest(std::int64_t last, const Use& use, RunContext& run) const
{
    if (used(interrupted(), last + 1, use, run))
        return Used::interrupted;
    if (used(due(), last + 1, use, run))
        return Used::due;
    return used(earlier(), last + 1, use, run) ? Used::earlier : Used::none;
}

bool CheckpointFolder::use_before(std::int64_t step, const Use& use, RunContext& run) const
{
    // It may be of the way that led there.
    std::filesystem::remove(interrupted());
    if (used(due(), step, use, run))
        return true;
    // Else the bad state would take the place of the good one when the next checkpoint is due.
    std::filesystem::remove(due());
    rename_if_there(earlier(), due());
    return used(due(), step, use, run);
}

void CheckpointFolder::write_due(const Checkpoint& checkpoint) const
{
    rename_if_there(due(), earlier());
    checkpoint.write(due());
    std::filesystem::remove(interrupted());
}

void CheckpointFolder::write_interrupted(const Checkpoint& checkpoint) const
{
    checkpoint.write(interrupted());
}

}  // namespace fresco::optimize
