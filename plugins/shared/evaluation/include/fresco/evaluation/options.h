#pragma once

#include <fresco/evaluation/statistics.h>
#include <fresco/option.h>

#include <cstdint>
#include <string>

/// \file Options that several evaluations declare.

namespace fresco::evaluation
{

/// The options `bootstrap_count` and `seed`: declared in a stage as `BootstrapOptions bootstrap{this};`.
class BootstrapOptions
{
  public:
    explicit BootstrapOptions(Configurable* owner, std::string seed_help = "Seed of the resampling");

    std::uint64_t seed() const { return static_cast<std::uint64_t>(*seed_); }
    Bootstrap operator*() const { return {.resamples = *bootstrap_count_, .seed = seed()}; }

  private:
    Option<int> bootstrap_count_;
    Option<int> seed_;
};

/// The option `protocol`, which protocol_of reads.
Option<std::string> protocol_option(Configurable* owner, std::string help);

}  // namespace fresco::evaluation
