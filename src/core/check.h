// CHECK states an invariant, which no input can break; input is answered by Error (core/error.h).
// CHECK(condition), CHECK_EQ(a, b), CHECK_LT, ... print both values, file and line, then end the program;
// DCHECK is for hot code and is compiled out of release builds. Each takes more to say:
//     CHECK_GE(width, 0) << "of segment " << i;
//
// Behind it stands glog; without it (in a browser) a few lines do the same.
#pragma once

#ifdef CUTICLE_WITH_GLOG
#include <glog/logging.h>
#else
#include <cstdlib>
#include <iostream>

namespace cuticle {
// Ends the program when the message that it collects is complete.
class FailedCheck {
  public:
    FailedCheck(const char *file, int line, const char *what) {
        std::cerr << file << ":" << line << ": check failed: " << what << " ";
    }
    [[noreturn]] ~FailedCheck() {
        std::cerr << std::endl;
        std::abort();
    }
    std::ostream &stream() { return std::cerr; }
};
struct Voidify {
    void operator&(std::ostream &) {}
};
} // namespace cuticle

#define CHECK(condition)                                                                                     \
    (condition) ? (void)0                                                                                    \
                : ::cuticle::Voidify() & ::cuticle::FailedCheck(__FILE__, __LINE__, #condition).stream()
#define CHECK_OP_(a, op, b) CHECK((a)op(b)) << "(" << (a) << " against " << (b) << ") "
#define CHECK_EQ(a, b) CHECK_OP_(a, ==, b)
#define CHECK_NE(a, b) CHECK_OP_(a, !=, b)
#define CHECK_LT(a, b) CHECK_OP_(a, <, b)
#define CHECK_LE(a, b) CHECK_OP_(a, <=, b)
#define CHECK_GT(a, b) CHECK_OP_(a, >, b)
#define CHECK_GE(a, b) CHECK_OP_(a, >=, b)
#define VLOG(level)                                                                                          \
    while (false)                                                                                            \
    std::cerr
#ifdef NDEBUG
#define DCHECK(condition) CHECK(true || (condition))
#define DCHECK_OP_(a, op, b) CHECK(true || ((a)op(b)))
#else
#define DCHECK(condition) CHECK(condition)
#define DCHECK_OP_(a, op, b) CHECK_OP_(a, op, b)
#endif
#define DCHECK_EQ(a, b) DCHECK_OP_(a, ==, b)
#define DCHECK_NE(a, b) DCHECK_OP_(a, !=, b)
#define DCHECK_LT(a, b) DCHECK_OP_(a, <, b)
#define DCHECK_LE(a, b) DCHECK_OP_(a, <=, b)
#define DCHECK_GT(a, b) DCHECK_OP_(a, >, b)
#define DCHECK_GE(a, b) DCHECK_OP_(a, >=, b)
#endif

#include <functional>
#include <string>

namespace cuticle {

// While it lives, a CHECK that fails on this thread also prints what `describe` returns: scene, pixel and
// sample of a render. It costs two pointers; describe, which must outlive it, runs only at the failure.
// InstallCheckHandler must have been called.
class CheckContext {
  public:
    explicit CheckContext(const std::function<std::string()> &describe);
    ~CheckContext();
    CheckContext(const CheckContext &) = delete;
    CheckContext &operator=(const CheckContext &) = delete;

  private:
    const std::function<std::string()> &describe_;
    const CheckContext *outer_;
    friend std::string CheckContexts();
};
// Returns what the contexts of this thread say, innermost first, a line each; "" without any.
std::string CheckContexts();

// Makes a failed CHECK print its contexts before the program ends. Programs call it once; libraries need not.
void InstallCheckHandler();

// Starts the log of a program: its name, a file that takes the log besides standard error ("" for none), and
// the level up to which VLOG speaks. The log on standard error holds warnings and errors.
void StartLog(const char *program, const std::string &file, int verbosity);

} // namespace cuticle
