// A Nav2 controller that hands on the commands of Octant's navigator. NOT TESTED: needs Nav2.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "geometry_msgs/msg/twist.hpp"
#include "nav2_core/controller.hpp"
#include "rclcpp/rclcpp.hpp"

namespace octant_nav2 {

class OctantController : public nav2_core::Controller {
 public:
  void configure(const rclcpp_lifecycle::LifecycleNode::WeakPtr& parent, std::string name,
                 std::shared_ptr<tf2_ros::Buffer> tf,
                 std::shared_ptr<nav2_costmap_2d::Costmap2DROS> costmap) override;
  void cleanup() override;
  void activate() override;
  void deactivate() override;
  // The navigator finds its own way by what it hears: Nav2's plan is not followed.
  void setPlan(const nav_msgs::msg::Path& path) override;
  geometry_msgs::msg::TwistStamped computeVelocityCommands(
      const geometry_msgs::msg::PoseStamped& pose, const geometry_msgs::msg::Twist& velocity,
      nav2_core::GoalChecker* goal_checker) override;
  void setSpeedLimit(const double& limit, const bool& percentage) override;

 private:
  rclcpp_lifecycle::LifecycleNode::WeakPtr node_;
  rclcpp::Subscription<geometry_msgs::msg::Twist>::SharedPtr commands_;
  std::mutex mutex_;
  geometry_msgs::msg::Twist last_;
  rclcpp::Time heard_;
  bool any_ = false;
  double timeout_s_ = 2.5;
  double limit_m_per_s_ = 0.0;  // 0: none
  double top_m_per_s_ = 0.5;
};

}  // namespace octant_nav2
