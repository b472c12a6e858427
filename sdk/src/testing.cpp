#include <fresco/plugin_library.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>

namespace fresco::testing
{
namespace
{

namespace fs = std::filesystem;

std::mutex lists_mutex;

fs::path made(const fs::path& folder)
{
    fs::create_directories(folder);
    return folder;
}

}  // namespace

TemporaryFolder::TemporaryFolder()
{
    std::string name = (fs::temp_directory_path() / "fresco-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
        throw Error(name + ": cannot be created");
    path_ = name;
}

TemporaryFolder::~TemporaryFolder()
{
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

TestRun::TestRun(int threads) : threads_(threads) {}
TestRun::~TestRun() = default;

void TestRun::progress(double, double, std::string_view) {}

void TestRun::check_canceled() const
{
    if (checks_left_ > 0 && --checks_left_ == 0)
        throw Canceled();
}

void TestRun::message(std::string_view text)
{
    const std::lock_guard lock(lists_mutex);
    messages.emplace_back(text);
}

void TestRun::warning(std::string_view text)
{
    message("warning: " + std::string(text));
}

void TestRun::metric(std::string_view name, double value)
{
    const std::lock_guard lock(lists_mutex);
    metrics[std::string(name)].push_back(value);
}

void TestRun::report(std::string_view key, Value value)
{
    const std::lock_guard lock(lists_mutex);
    reported.set(key, std::move(value));
}

fs::path TestRun::preview_folder()
{
    return made(folder_.path() / "preview");
}

fs::path TestRun::scratch_folder()
{
    return made(folder_.path() / "scratch");
}

fs::path TestRun::checkpoint_folder()
{
    return made(folder_.path() / "checkpoint");
}

void TestRun::reads_file(const fs::path& file)
{
    const std::lock_guard lock(lists_mutex);
    files_read.push_back(file);
}

void TestRun::reads_folder(const fs::path& folder, std::string_view names)
{
    const std::lock_guard lock(lists_mutex);
    folders_read.push_back(folder / names);
}

TestFactory::~TestFactory() = default;

void TestFactory::add(const std::string& type, std::function<std::shared_ptr<Component>()> make)
{
    makers_[type] = std::move(make);
}

std::shared_ptr<Component> TestFactory::create(std::string_view kind, const Value& config)
{
    const std::string key = std::string(kind) + to_json(config);
    if (const auto made = made_.find(key); made != made_.end())
        return made->second;
    const std::string& type = config.at("type").as_string();
    const auto maker = makers_.find(type);
    if (maker == makers_.end())
        throw Error("the test's factory has no component \"" + type + "\"");
    auto component = maker->second();
    Value options{Value::Map{}};
    for (const auto& [name, value] : config.as_map())
        if (name != "type")
            options.set(name, value);
    // As in the host, slots that the configuration leaves out get their defaults.
    for (const Parameter* parameter : component->parameters())
    {
        const OptionDeclaration& option = parameter->declaration();
        if (option.is_slot() && option.default_value.is_map() && options.find(option.name) == nullptr)
            options.set(option.name, option.default_value);
    }
    component->configure(options, *this);
    return made_[key] = component;
}

void run_stage(Stage& stage, const Value& options, const Inputs& inputs, const fs::path& folder, TestRun& run,
               ComponentFactory& factory)
{
    stage.configure(options, factory);
    for (const auto& [name, artifact] : inputs)
    {
        const auto port = std::ranges::find(stage.inputs(), name, &InputPort::name);
        if (port == stage.inputs().end())
            throw Error("the stage has no input \"" + name + "\"");
        (*port)->set(artifact);
    }
    for (OutputPort* port : stage.outputs())
    {
        fs::create_directories(folder / port->name());
        port->set_folder({folder / port->name(), folder});
    }
    stage.run(run);
    for (const OutputPort* port : stage.outputs())
        if (port->is_left_out())
            fs::remove(folder / port->name());
        else
            port->save();
}

void run_stage(const fs::path& library, std::string_view type, Value options, const Inputs& inputs, const fs::path& folder,
               TestRun& run, const std::map<std::string, std::shared_ptr<Component>>& components)
{
    const auto stage = make_from_plugin<Stage>(library, type);
    TestFactory factory;
    for (const Parameter* parameter : stage->parameters())
        if (const auto found = components.find(parameter->name()); found != components.end())
        {
            factory.add("test." + found->first, [component = found->second] { return component; });
            options.set(found->first, Value::Map{{"type", "test." + found->first}});
        }
    run_stage(*stage, options, inputs, folder, run, factory);
}

std::unique_ptr<Configurable> make_from_plugin(const fs::path& library, std::string_view type)
{
    try
    {
        return PluginLibrary::open(library).make(type);
    }
    catch (const Error& error)
    {
        throw Error(library.string() + ": " + error.what());
    }
}

}  // namespace fresco::testing
