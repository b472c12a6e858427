#include "page_child.h"

#include "worker/worker_factory.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/host/process.h>

#include <cstdio>
#include <exception>
#include <poll.h>

namespace fresco::host
{
namespace
{

/// In the store, which is in use as long as it is there: nobody tidies up or removes results meanwhile.
class RequestFolder
{
  public:
    explicit RequestFolder(const Store& store) : in_use_(store_lock(store))
    {
        in_use_.wait_shared();
        path_ = store.make_temporary();
    }
    ~RequestFolder() { remove_quietly(path_); }
    RequestFolder(const RequestFolder&) = delete;
    RequestFolder& operator=(const RequestFolder&) = delete;
    std::filesystem::path file() const { return path_ / "request.json"; }

  private:
    FileLock in_use_;
    std::filesystem::path path_;
};

}  // namespace

Value image_component(const Catalog& catalog)
{
    for (const TypeDescription* type : catalog.types())
        if (type->kind == ImageIo::component_kind)
            return Value::Map{{"type", type->type}, {"library", type->library.string()}, {"hash", type->library_hash}};
    return {};
}

std::shared_ptr<ImageIo> image_codec(const Value& component)
{
    const std::string& type = component.at("type").as_string();
    WorkerFactory factory({{type, component.at("library").as_string()}},
                          Value::Map{{type, Value::Map{{"hash", component.at("hash")}}}});
    auto codec = std::dynamic_pointer_cast<ImageIo>(factory.create(ImageIo::component_kind, Value::Map{{"type", type}}));
    if (codec == nullptr)
        throw Error(type + " reads and writes no pictures");
    return codec;
}

std::string run_page_child(const std::string& command, const Value& request, const Store& store)
{
    const RequestFolder folder(store);
    write_file(folder.file(), to_json(request));
    const Child child = start_child({command, folder.file().string()});
    LineBuffer output;
    ProcessEnd end;
    std::string text;
    std::string line;
    for (bool open = true; open;)
    {
        pollfd descriptor{child.output.get(), POLLIN, 0};
        poll(&descriptor, 1, -1);
        open = output.read_from(child.output.get());
        while (output.next(line))
            text = line;
    }
    while (!take_end(child.pid, end))
        poll(nullptr, 0, 5);
    if (end.exit_code == 0)
        return "";
    if (end.signal != 0)
        return "the process that makes them ended by " + signal_text(end.signal);
    return text.empty() ? "the process that makes them ended with code " + std::to_string(end.exit_code) : text;
}

int serve_page(const std::filesystem::path& request_file, const std::function<void(const Value&)>& write)
{
    try
    {
        write(parse_json(read_text_file(request_file), request_file.string()));
        return 0;
    }
    catch (const std::exception& error)
    {
        std::puts(error.what());
        return 1;
    }
}

}  // namespace fresco::host
