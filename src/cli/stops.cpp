#include "cli/stops.h"

#include <csignal>
#include <unistd.h>

namespace cuticle {

namespace {

std::atomic<bool> interrupted = false;
std::atomic<int> stoppedBy = 0; // the signal that asked first

extern "C" void OnStop(int signal) {
    int none = 0;
    if (!stoppedBy.compare_exchange_strong(none, signal) && signal == SIGINT)
        _exit(128 + SIGINT);
    interrupted = true;
}

} // namespace

void CatchStops() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU}) {
        struct sigaction before {
        }, action{};
        action.sa_handler = OnStop;
        action.sa_flags = SA_RESTART;
        if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
            sigaction(signal, &action, nullptr);
    }
}

const std::atomic<bool> &StopAsked() { return interrupted; }
int StopStatus() { return 128 + stoppedBy; }

} // namespace cuticle
