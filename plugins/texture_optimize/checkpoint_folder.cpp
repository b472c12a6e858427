#include "checkpoint_folder.h"

#include <fresco/error.h>

#include <limits>
#include <system_error>

namespace fresco::optimize
{
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

bool used(const std::filesystem::path& file, std::int64_t before, const CheckpointFolder::Use& use,
          const CheckpointFolder::Warn& warn)
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
        warn(std::string("the checkpoint cannot be used: ") + error.what());
        return false;
    }
}

}  // namespace

CheckpointFolder::Used CheckpointFolder::use_latest(const Use& use, const Warn& warn) const
{
    constexpr auto any = std::numeric_limits<std::int64_t>::max();
    if (used(interrupted(), any, use, warn))
        return Used::interrupted;
    if (used(due(), any, use, warn))
        return Used::due;
    return used(earlier(), any, use, warn) ? Used::earlier : Used::none;
}

bool CheckpointFolder::use_before(std::int64_t step, const Use& use, const Warn& warn) const
{
    // It may be of the way that led there.
    std::filesystem::remove(interrupted());
    if (used(due(), step, use, warn))
        return true;
    // Else the bad state would take the place of the good one when the next checkpoint is due.
    std::filesystem::remove(due());
    rename_if_there(earlier(), due());
    return used(due(), step, use, warn);
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
