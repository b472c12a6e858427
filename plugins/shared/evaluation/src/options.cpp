#include <fresco/evaluation/options.h>

#include <utility>

namespace fresco::evaluation
{

BootstrapOptions::BootstrapOptions(Configurable* owner, std::string seed_help)
    : bootstrap_count_(owner, "bootstrap_count", 2000, range(100, 1'000'000), "Number of resamples for the 95% intervals"),
      seed_(owner, "seed", 1, range(0, 2'000'000'000), std::move(seed_help))
{
}

Option<std::string> protocol_option(Configurable* owner, std::string help)
{
    return {owner, "protocol", "paper", one_of({"paper", "released"}), std::move(help)};
}

}  // namespace fresco::evaluation
