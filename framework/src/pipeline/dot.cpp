#include "pipeline/dot.h"

#include <map>
#include <ostream>

namespace fresco::host
{

std::string dot_quoted(std::string_view text)
{
    std::string result = "\"";
    for (const char c : text)
    {
        if (c == '\n')
            result += "\\n";
        else if (static_cast<unsigned char>(c) < 0x20)
            result += ' ';
        else
        {
            // Graphviz reads backslash sequences in labels: a backslash itself is doubled.
            if (c == '"' || c == '\\')
                result += '\\';
            result += c;
        }
    }
    return result + '"';
}

void write_dot(const Pipeline& pipeline, std::ostream& out)
{
    out << "digraph pipeline {\n    rankdir=LR;\n    node [shape=box, style=rounded];\n";
    // A stage and a file may have one name: numbers keep them apart.
    std::map<std::string, std::size_t> numbers;
    for (const PipelineStage& stage : pipeline.stages)
    {
        const std::size_t number = numbers.emplace(stage.name, numbers.size()).first->second;
        const std::string type = stage.type ? stage.type->type : "";
        out << "    stage" << number << " [label=" << dot_quoted(stage.name + "\n" + type) << "];\n";
    }
    std::map<std::string, std::size_t> files;
    for (const PipelineStage& stage : pipeline.stages)
        for (const Wire& wire : stage.wires)
        {
            std::string from;
            if (wire.from_stage.empty())
            {
                const auto [file, fresh] = files.emplace(wire.file.string(), files.size());
                from = "file" + std::to_string(file->second);
                if (fresh)
                    out << "    " << from << " [shape=note, style=\"\", label=" << dot_quoted(wire.file.filename().string())
                        << ", tooltip=" << dot_quoted(wire.file.string()) << "];\n";
            }
            else
                from = "stage" + std::to_string(numbers.at(wire.from_stage));
            const std::string ports =
                wire.from_port.empty() || wire.from_port == wire.port ? wire.port : wire.from_port + " → " + wire.port;
            out << "    " << from << " -> stage" << numbers.at(stage.name) << " [label=" << dot_quoted(ports)
                << ", tooltip=" << dot_quoted(wire.artifact) << "];\n";
        }
    out << "}\n";
}

}  // namespace fresco::host
