#include "codec/beside.h"

#include <atomic>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

namespace fluxgs::codec {
namespace {

TEST(Beside, LongWorkIsDoneWhileTheCallerDoesOther) {
  std::atomic<bool> caller_came = false;
  Beside work(true, [&] {
    caller_came.wait(false);  // for ever, were it done by the caller
    return std::this_thread::get_id();
  });
  caller_came = true;
  caller_came.notify_all();
  EXPECT_NE(work.result(), std::this_thread::get_id());
}

TEST(Beside, ShortWorkIsDoneByTheCaller) {
  bool done = false;
  Beside work(false, [&] {
    done = true;
    return std::this_thread::get_id();
  });
  EXPECT_FALSE(done);
  EXPECT_EQ(work.result(), std::this_thread::get_id());
}

TEST(Beside, ThrowsWhatTheWorkHasThrown) {
  for (const bool long_enough : {false, true}) {
    Beside work(long_enough, []() -> int { throw std::runtime_error("no memory"); });
    EXPECT_THROW(work.result(), std::runtime_error) << long_enough;
  }
}

TEST(Beside, EndsBeforeWhatTheWorkRefersTo) {
  std::atomic<bool> done = false;
  {
    Beside work(true, [&] { return std::this_thread::yield(), done = true, 0; });
  }
  EXPECT_TRUE(done);
}

}  // namespace
}  // namespace fluxgs::codec
