#include "worker/worker.h"

namespace fresco::host
{
namespace
{

Value to_value(const WorkerInput& input)
{
    return Value::Map{
        {"port", input.port},          {"artifact", input.artifact},
        {"from", input.from},          {"object", input.object},
        {"output", input.output},      {"references", Value::List(input.references.begin(), input.references.end())},
        {"file", input.file.string()}, {"reader", input.reader}};
}

WorkerInput input_from(const Value& value)
{
    WorkerInput input;
    input.port = value.at("port").as_string();
    input.artifact = value.at("artifact").as_string();
    input.from = value.at("from").as_string();
    input.object = value.at("object").as_string();
    input.output = value.at("output").as_string();
    for (const auto& reference : value.at("references").as_list())
        input.references.push_back(reference.as_string());
    input.file = value.at("file").as_string();
    input.reader = value.at("reader");
    return input;
}

}  // namespace

Value to_value(const WorkerRequest& request)
{
    Value::List inputs;
    for (const auto& input : request.inputs)
        inputs.push_back(to_value(input));
    Value::Map libraries;
    for (const auto& [type, file] : request.libraries)
        libraries.emplace_back(type, file.string());
    Value::List files;
    for (const auto& file : request.files)
        files.push_back(to_value(file));
    return Value::Map{{"store", request.store.string()},
                      {"out", request.out.string()},
                      {"preview_folder", request.preview_folder.string()},
                      {"stage", request.stage},
                      {"type", request.type},
                      {"options", request.options},
                      {"key", request.key},
                      {"key_document", request.key_document},
                      {"inputs", std::move(inputs)},
                      {"libraries", std::move(libraries)},
                      {"roots", to_value(request.roots)},
                      {"upstream", request.upstream.string()},
                      {"fetch", request.fetch},
                      {"files", std::move(files)},
                      {"threads", request.threads}};
}

WorkerRequest worker_request_from(const Value& value)
{
    WorkerRequest request;
    request.store = value.at("store").as_string();
    request.out = value.at("out").as_string();
    request.preview_folder = value.at("preview_folder").as_string();
    request.stage = value.at("stage").as_string();
    request.type = value.at("type").as_string();
    request.options = value.at("options");
    request.key = value.at("key").as_string();
    request.key_document = value.at("key_document");
    for (const auto& input : value.at("inputs").as_list())
        request.inputs.push_back(input_from(input));
    for (const auto& [type, file] : value.at("libraries").as_map())
        request.libraries[type] = file.as_string();
    request.roots = input_roots_from(value.at("roots"));
    request.upstream = value.at("upstream").as_string();
    request.fetch = value.at("fetch").as_string();
    for (const auto& file : value.at("files").as_list())
        request.files.push_back(dependency_from(file));
    request.threads = static_cast<int>(value.at("threads").as_int());
    return request;
}

}  // namespace fresco::host
