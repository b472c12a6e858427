#include "torch_state.h"
#include "zip_archive.h"

#include <fresco/error.h>

#include <fmt/format.h>

namespace fresco::weights
{

StateDict parse_zip_pickle(std::span<const std::byte> bytes, std::string_view source)
{
    const detail::ZipArchive archive(bytes, source);
    const std::string name = archive.only_name_with_end("/data.pkl");
    const std::string folder = name.substr(0, name.size() - std::string_view("data.pkl").size());
    if (archive.contains(folder + "constants.pkl"))
        throw Error(std::string(source) +
                    ": is a TorchScript program, not a state dict; save model.state_dict() with torch.save");
    if (archive.contains(folder + "byteorder"))
    {
        const auto order = archive.contents(folder + "byteorder");
        if (std::string_view(reinterpret_cast<const char*>(order.data()), order.size()) != "little")
            throw Error(std::string(source) + ": the numbers are big-endian; save it on another machine");
    }

    const auto pickle = archive.contents(name);
    detail::PickleMachine machine(pickle, std::string(source) + ": " + name);
    const detail::Node root = machine.run();
    if (machine.position() != pickle.size())
        machine.fail(machine.position(), "bytes after the pickle");
    std::vector<std::span<const std::byte>> contents;
    for (const auto& storage : machine.storages())
    {
        const std::string entry = folder + "data/" + std::string(storage.key);
        contents.push_back(archive.contents(entry));
        const std::size_t size = size_of(storage.type);
        if (contents.back().size() % size != 0 || contents.back().size() / size != storage.count)
            throw Error(fmt::format("{}: entry '{}' has {} bytes, not {} elements of {}", source, entry, contents.back().size(),
                                    storage.count, size));
    }
    StateDict result;
    result.form = Form::zip_pickle;
    result.tensors = detail::tensors_of(machine, root, [&](std::size_t storage) { return contents[storage]; });
    return result;
}

}  // namespace fresco::weights
