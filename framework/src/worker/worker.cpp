#include "worker/worker.h"
#include "base/common.h"
#include "base/fault.h"
#include "worker/stage_run.h"
#include "worker/worker_factory.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/process.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <utility>

namespace fresco::host
{

namespace
{

constexpr const char* name_begins = "fresco-";

/// Empty where it is not set.
fs::path temporary_folder()
{
    const char* folder = std::getenv("TMPDIR");
    return folder == nullptr ? fs::path() : fs::path(folder);
}

WorkerInput input_from(const Value& value)
{
    return {.port = value.at("port").as_string(),
            .from = value.at("from").as_string(),
            .object = value.at("object").as_string(),
            .output = value.at("output").as_string(),
            .references = each(value.at("references").as_list(), &Value::as_string),
            .file = value.at("file").as_string(),
            .reader = value.at("reader")};
}

WorkerRequest request_from(const Value& value)
{
    std::map<std::string, fs::path> libraries;
    for (const auto& [type, library] : value.at("libraries").as_map())
        libraries[type] = library.as_string();
    return {.store = value.at("store").as_string(),
            .out = value.at("out").as_string(),
            .preview_folder = value.at("preview_folder").as_string(),
            .stage = value.at("stage").as_string(),
            .type = value.at("type").as_string(),
            .options = value.at("options"),
            .key = value.at("key").as_string(),
            .key_document = value.at("key_document"),
            .inputs = each(value.at("inputs").as_list(), input_from),
            .libraries = std::move(libraries),
            .files = each(value.at("files").as_list(), dependency_from),
            .threads = static_cast<int>(value.at("threads").as_int()),
            .on_gpu = value.at("on_gpu").as_bool()};
}

std::string with_advice(std::string text)
{
    if (text.find(std::generic_category().message(ENOSPC)) == std::string::npos || text.find("--store") != std::string::npos)
        return text;
    const std::string temporary = temporary_folder_in(text);
    return text +
           (temporary.empty() ? ": free some space, or put the store elsewhere with --store"
                              : ": free some space in " + temporary + ", or set TMPDIR to another folder") +
           "; nothing was lost";
}

int guarded_run(const fs::path& request_file, WorkerChannel& channel)
{
    const auto fail = [&](const std::string& text, int code)
    {
        channel.send("failed", {{"text", text}});
        return code;
    };
    try
    {
        WorkerRequest request = request_from(parse_json(read_text_file(request_file), request_file.string()));
        set_fault_stage(request.stage);
        run_stage(std::move(request), request_file.parent_path().filename().string(), channel);
        return 0;
    }
    catch (const Damage& damage)
    {
        channel.send("damaged", {{"object", damage.object}, {"text", damage.text}});
        return worker_damaged_input;
    }
    catch (const Canceled&)
    {
        channel.send("canceled");
        return worker_canceled;
    }
    catch (const PluginFailure& error)
    {
        return fail(error.what(), worker_plugin);
    }
    catch (const MissingInput& error)
    {
        return fail(error.what(), worker_missing_input);
    }
    catch (const Error& error)
    {
        return fail(with_advice(error.what()), worker_failed);
    }
    catch (const std::bad_alloc&)
    {
        return fail("there is not enough memory: close other programs, raise --stage-memory where it is set, or ask for less "
                    "(smaller sizes, fewer frames, --cores 1)",
                    worker_failed);
    }
    catch (const std::system_error& error)
    {
        return fail(with_advice(error.what()), worker_failed);
    }
    catch (const std::exception& error)
    {
        return fail(std::string("unexpected error, please report it to the plugin's author: ") + error.what(), worker_failed);
    }
    catch (...)
    {
        return fail("something other than an exception was thrown; please report it to the plugin's author", worker_failed);
    }
}

}  // namespace

fs::path make_scratch_folder(const Store& store, const std::string& prefix)
{
    if (const fs::path folder = temporary_folder(); folder.is_absolute())
    {
        std::string name = (folder / (name_begins + prefix + ".XXXXXX")).string();
        if (::mkdtemp(name.data()) != nullptr)
            return name;
    }
    return store.make_temporary(prefix);
}

std::string temporary_folder_in(const std::string& text)
{
    const fs::path folder = temporary_folder();
    return folder.is_absolute() && text.find((folder / name_begins).string()) != std::string::npos ? folder.string() : "";
}

void remove_scratch_folders(const std::string& prefix)
{
    std::error_code error;
    const fs::path folder = temporary_folder();
    if (!folder.is_absolute())
        return;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
        if (entry.path().filename().string().starts_with(name_begins + prefix + "."))
            remove_quietly(entry.path());
}

void internal_run(const fs::path& request_file)
{
    take_stop_signals();
    adopt_orphans();
    WorkerChannel channel;
    const int code = guarded_run(request_file, channel);
    end_descendants();
    std::fflush(nullptr);
    // Static destructors of libraries have nothing to do here that is worth a crash after the work is done.
    std::_Exit(code);
}

}  // namespace fresco::host
