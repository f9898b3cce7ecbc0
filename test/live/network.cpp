#include <talus/live/network.h>

#include <stdexcept>

#include "robot.h"

using namespace talus::live;
using namespace talus::test;

TEST(Network, carries_messages_byte_by_byte_also_large_ones)
{
  Participant network(own_domain(), "talus_test");
  Subscription hears(network, "/points", kCloudType, {true, false, 10});
  Publication says(network, "/points", kCloudType, {true, false, 10});
  std::string small = floor_cloud(0), large(std::size_t{2} << 20, '\1');
  large.replace(0, 4, std::string("\0\1\0\0", 4));
  for (const auto* message : {&small, &large})
  {
    says.write(*message);
    ASSERT_TRUE(network.wait(5));
    const auto came = hears.take();
    ASSERT_TRUE(came);
    EXPECT_EQ(came->substr(0, message->size()), *message);
    EXPECT_FALSE(hears.take());
  }
  EXPECT_TRUE(network.offers().empty()) << "its own";
  EXPECT_EQ(hears.lost(), 0U);
}

TEST(Network, gives_who_comes_later_what_is_kept)
{
  Participant network(own_domain(), "talus_test");
  Publication says(network, "/tf_static", kTfType, {true, true, 1});
  const std::string message = tf(0, "base_link", "lidar", 1);
  says.write(message);
  Subscription hears(network, "/tf_static", kTfType, {true, true, 1});
  ASSERT_TRUE(network.wait(5));
  const auto came = hears.take();
  ASSERT_TRUE(came);
  EXPECT_EQ(came->substr(0, message.size()), message);
}

TEST(Network, heeds_the_variables_of_ros)
{
  ::unsetenv("CYCLONEDDS_URI");
  EXPECT_EQ(configuration_of_environment().find("127.0.0.1"), std::string::npos);
  ::setenv("ROS_LOCALHOST_ONLY", "1", 1);
  EXPECT_NE(configuration_of_environment().find("127.0.0.1"), std::string::npos);
  ::unsetenv("ROS_LOCALHOST_ONLY");
  ::setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST", 1);
  EXPECT_NE(configuration_of_environment().find("127.0.0.1"), std::string::npos);
  ::setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "NEAR", 1);
  EXPECT_THROW(configuration_of_environment(), std::runtime_error);
  ::unsetenv("ROS_AUTOMATIC_DISCOVERY_RANGE");
  ::setenv("ROS_STATIC_PEERS", "10.0.0.7;robot.local", 1);
  EXPECT_NE(configuration_of_environment().find("\"robot.local\""), std::string::npos);
  ::setenv("ROS_STATIC_PEERS", "\"/><x", 1);
  EXPECT_THROW(configuration_of_environment(), std::runtime_error);
  ::unsetenv("ROS_STATIC_PEERS");
  for (const char* wrong : {"233", "-1", "a", "1.5"})
  {
    ::setenv("ROS_DOMAIN_ID", wrong, 1);
    EXPECT_THROW(domain_of_environment(), std::runtime_error);
  }
  ::setenv("ROS_DOMAIN_ID", "42", 1);
  EXPECT_EQ(domain_of_environment(), 42);
}
