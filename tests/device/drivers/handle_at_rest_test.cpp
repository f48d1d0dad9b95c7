#include "device/drivers/handle_at_rest.h"

#include <gtest/gtest.h>

#include "device/drivers/reported_device.h"

namespace kerf {
namespace {

using test::Served;

TEST(HandleAtRest, RequiresAHandleObservedAtRest) {
  const Served served;
  HandleAtRest at_rest(*served.servo);
  ServoSample sample;
  const auto take = [&](double at_s) {
    sample.at_s = at_s;
    return at_rest.Update(sample);
  };
  EXPECT_FALSE(take(10));
  EXPECT_FALSE(take(10.6));  // the handle's motion during the gap is unknown
  for (int i = 1; i <= 10; ++i) EXPECT_FALSE(take(10.6 + 0.05 * i - 1e-9)) << i;
  EXPECT_TRUE(take(11.15));
  sample.sample.X_DH.p_AB.x += 3;
  EXPECT_FALSE(take(11.2));
}

}  // namespace
}  // namespace kerf
