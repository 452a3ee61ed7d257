#include "core/check.h"

#include "core/error.h"
#include "core/printable.h"

#include <cstdio>
#include <fstream>
#include <mutex>

namespace cuticle {

namespace {

thread_local const CheckContext *innermost = nullptr;

} // namespace

CheckContext::CheckContext(const std::function<std::string()> &describe)
    : describe_(describe), outer_(innermost) {
    innermost = this;
}
CheckContext::~CheckContext() { innermost = outer_; }

std::string CheckContexts() {
    std::string text;
    for (const CheckContext *c = innermost; c; c = c->outer_)
        text += Printable(c->describe_()) + "\n";
    return text;
}

#ifdef CUTICLE_WITH_GLOG

namespace {

// Copies every message of the log into one file, at once: what was said before a crash is there.
class LogFile : public google::LogSink {
  public:
    void Open(const std::string &name) {
        file_.open(name, std::ios::app);
        if (!file_)
            throw Error("the log \"{}\" cannot be written", name);
    }
    void send(google::LogSeverity severity, const char *, const char *base, int line,
              const google::LogMessageTime &time, const char *message, size_t length) override {
        const std::lock_guard lock(mutex_);
        file_ << ToString(severity, base, line, time, message, length) << std::endl;
    }

  private:
    std::mutex mutex_;
    std::ofstream file_;
};

// A function and no lambda: glog's type asks for the attribute, which clang checks (and of which the
// standard's [[noreturn]] is no part).
__attribute__((noreturn)) void FailWithContexts() {
    std::fputs(CheckContexts().c_str(), stderr);
    std::abort();
}

} // namespace

void InstallCheckHandler() { google::InstallFailureFunction(FailWithContexts); }

void StartLog(const char *program, const std::string &file, int verbosity) {
    google::InitGoogleLogging(program);
    // No files of glog's own naming; what is less than a warning reaches the terminal with -v only.
    for (const google::LogSeverity s :
         {google::GLOG_INFO, google::GLOG_WARNING, google::GLOG_ERROR, google::GLOG_FATAL})
        google::SetLogDestination(s, "");
    FLAGS_stderrthreshold = verbosity > 0 ? google::GLOG_INFO : google::GLOG_WARNING;
    FLAGS_v = verbosity;
    if (file.empty())
        return;
    static LogFile log;
    log.Open(file);
    google::AddLogSink(&log);
}

#else

void InstallCheckHandler() {}
void StartLog(const char *, const std::string &, int) {}

#endif

} // namespace cuticle
