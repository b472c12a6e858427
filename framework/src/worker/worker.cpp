#include "worker/worker.h"
#include "base/fault.h"
#include "base/machine.h"
#include "base/unit_text.h"
#include "worker/scratch_folder.h"
#include "worker/stack_overflow.h"
#include "worker/stage_run.h"
#include "worker/worker_factory.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/process.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <system_error>
#include <utility>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

std::string with_advice(std::string text)
{
    if (text.find(std::generic_category().message(ENOSPC)) == std::string::npos)
        return text;
    const std::string temporary = temporary_folder_in(text);
    return text +
           (temporary.empty() ? ": free some space, or put the store elsewhere with --store"
                              : ": free some space in " + temporary + ", or set TMPDIR to another folder") +
           "; nothing was lost";
}

std::string memory_text()
{
    const char* less = "ask for less (smaller sizes, fewer frames, --cores 1)";
    const double limit_mb = memory_limit_mb();
    if (limit_mb == 0)
        return std::string("there is not enough memory: close other programs, or ") + less;
    return "it needs more memory than the limit of " + size_text(limit_mb) + ": raise it (--isolate-memory, ulimit), or " + less;
}

int guarded_run(const fs::path& request_file, WorkerChannel& channel)
{
    std::string failed;
    int code = worker_failed;
    try
    {
        WorkerRequest request = worker_request_from(parse_json(read_text_file(request_file), request_file.string()));
        set_fault_stage(request.stage);
        set_input_roots(request.roots);
        try
        {
            run_stage(std::move(request), request_file.parent_path().filename().string(), channel);
            return channel.lost() ? worker_lost_channel : 0;
        }
        catch (const DamagedInput& input)
        {
            channel.send("damaged", {{"object", input.damage.object}, {"text", input.damage.text}});
            return worker_damaged_input;
        }
        catch (const Canceled&)
        {
            if (channel.lost())
                return worker_lost_channel;
            channel.send("canceled");
            return worker_canceled;
        }
    }
    catch (const PluginFailure& error)
    {
        failed = error.what();
        code = worker_plugin;
    }
    catch (const MissingInput& error)
    {
        failed = error.what();
        code = worker_missing_input;
    }
    catch (const Error& error)
    {
        failed = with_advice(error.what());
    }
    catch (const std::bad_alloc&)
    {
        failed = memory_text();
    }
    catch (const std::system_error& error)
    {
        failed = with_advice(error.what());
    }
    catch (const std::exception& error)
    {
        failed = std::string("unexpected error, please report it to the plugin's author: ") + error.what();
    }
    catch (...)
    {
        failed = "something other than an exception was thrown; please report it to the plugin's author";
    }
    channel.send("failed", {{"text", failed}});
    return code;
}

}  // namespace

void internal_run(const fs::path& request_file)
{
    take_stop_signals();
    report_stack_overflow();
    adopt_orphans();
    WorkerChannel channel;
    const int code = guarded_run(request_file, channel);
    end_descendants();
    std::fflush(nullptr);
    // Static destructors of libraries have nothing to do here that is worth a crash after the work is done.
    std::_Exit(code);
}

}  // namespace fresco::host
