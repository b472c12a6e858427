// Crashes as soon as it is opened.
#include <csignal>

static const int crashed = std::raise(SIGSEGV);
