#include "run/stop_signals.h"

#include <fresco/error.h>

#include <csignal>
#include <sys/signalfd.h>
#include <unistd.h>
#include <utility>

namespace fresco::host
{

StopSignals::StopSignals()
{
    sigset_t taken;
    sigemptyset(&taken);
    for (const int number : {SIGINT, SIGTERM, SIGCHLD})
        sigaddset(&taken, number);
    // Under nohup it stays ignored.
    struct sigaction hangup
    {
    };
    if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN)
        sigaddset(&taken, SIGHUP);
    sigprocmask(SIG_BLOCK, &taken, &before_);
    fd_ = FileDescriptor(signalfd(-1, &taken, SFD_CLOEXEC | SFD_NONBLOCK));
    if (!fd_.valid())
        throw Error("cannot handle signals: no file descriptor left");
}

StopSignals::~StopSignals()
{
    take();
    // A scheduler may repeat it while the process writes its last files.
    if (told_to_end_)
        for (const int number : {SIGTERM, SIGHUP})
            std::signal(number, SIG_IGN);
    sigprocmask(SIG_SETMASK, &before_, nullptr);
}

int StopSignals::take()
{
    int stops = 0;
    signalfd_siginfo info{};
    while (read(fd_.get(), &info, sizeof info) == static_cast<ssize_t>(sizeof info))
    {
        const bool asked = info.ssi_signo == SIGINT;
        const bool told = info.ssi_signo == SIGTERM || info.ssi_signo == SIGHUP;
        stops += asked || (told && !std::exchange(told_to_end_, true)) ? 1 : 0;
    }
    return stops;
}

}  // namespace fresco::host
