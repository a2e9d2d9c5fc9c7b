// SPDX-License-Identifier: BSD-3-Clause
// Two callbacks of roscpp that write one number without a lock: the thread sanitizer has to say so
// in spite of what test/sanitizers/thread.supp leaves out.
#include <ros/callback_queue.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <iostream>
#include <thread>

namespace {

int counter = 0;

class Increment : public ros::CallbackInterface {
 public:
  CallResult call() override {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // both threads are in here at once
    ++counter;
    return Success;
  }
};

}  // namespace

int main() {
  ros::CallbackQueue queue;
  for (int i = 0; i < 200; ++i) queue.addCallback(boost::make_shared<Increment>());
  const auto callAll = [&] {
    while (!queue.isEmpty()) queue.callOne();
  };
  std::thread other(callAll);
  callAll();
  other.join();
  std::cout << counter << " calls\n";
  return 0;
}
