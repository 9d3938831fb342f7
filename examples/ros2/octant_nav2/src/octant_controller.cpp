// A Nav2 controller that hands on the commands of Octant's navigator. NOT TESTED: needs Nav2.
#include "octant_nav2/octant_controller.hpp"

#include <algorithm>
#include <cmath>

#include "nav2_core/controller_exceptions.hpp"
#include "pluginlib/class_list_macros.hpp"

namespace octant_nav2 {

void OctantController::configure(const rclcpp_lifecycle::LifecycleNode::WeakPtr& parent,
                                 std::string name, std::shared_ptr<tf2_ros::Buffer>,
                                 std::shared_ptr<nav2_costmap_2d::Costmap2DROS>) {
  node_ = parent;
  auto node = parent.lock();
  timeout_s_ = node->declare_parameter(name + ".timeout_s", timeout_s_);
  top_m_per_s_ = node->declare_parameter(name + ".top_speed_m_per_s", top_m_per_s_);
  const auto topic =
      node->declare_parameter(name + ".command_topic", std::string("octant/cmd_vel"));
  commands_ = node->create_subscription<geometry_msgs::msg::Twist>(
      topic, rclcpp::QoS(10), [this](const geometry_msgs::msg::Twist& command) {
        std::lock_guard<std::mutex> lock(mutex_);
        last_ = command;
        heard_ = node_.lock()->now();
        any_ = true;
      });
}

void OctantController::cleanup() { commands_.reset(); }

void OctantController::activate() {
  std::lock_guard<std::mutex> lock(mutex_);
  any_ = false;  // commands from before do not count
}

void OctantController::deactivate() {}

void OctantController::setPlan(const nav_msgs::msg::Path&) {}

geometry_msgs::msg::TwistStamped OctantController::computeVelocityCommands(
    const geometry_msgs::msg::PoseStamped& pose, const geometry_msgs::msg::Twist&,
    nav2_core::GoalChecker*) {
  std::lock_guard<std::mutex> lock(mutex_);
  const auto now = node_.lock()->now();
  geometry_msgs::msg::TwistStamped command;
  command.header.stamp = now;
  command.header.frame_id = pose.header.frame_id;
  if (!any_) {
    return command;  // stands until the navigator speaks
  }
  if ((now - heard_).seconds() > timeout_s_) {
    throw nav2_core::ControllerTimedOut("Octant's navigator has not commanded anything for long");
  }
  command.twist = last_;
  if (limit_m_per_s_ > 0.0 && std::abs(last_.linear.x) > limit_m_per_s_) {
    const double share = limit_m_per_s_ / std::abs(last_.linear.x);
    command.twist.linear.x *= share;  // slower along the same arc
    command.twist.angular.z *= share;
  }
  return command;
}

void OctantController::setSpeedLimit(const double& limit, const bool& percentage) {
  std::lock_guard<std::mutex> lock(mutex_);
  limit_m_per_s_ = percentage ? 0.01 * limit * top_m_per_s_ : limit;
}

}  // namespace octant_nav2

PLUGINLIB_EXPORT_CLASS(octant_nav2::OctantController, nav2_core::Controller)
