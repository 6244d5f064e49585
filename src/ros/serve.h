// What every service of the node does: check, call, answer.
#pragma once

#include <exception>
#include <string>

#include <ros/node_handle.h>

#include "deformable_sim/core/command.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/ros/careful_messages.h"

namespace deformable_sim {

/// OK may carry a note: accepted, but limited.
inline Status answer(const Reply& reply) {
  Status status = reply.status;
  if (status.ok()) status.message = reply.note;
  return status;
}

/// The status of what `action` returns or throws. A refusal is an answer: the call itself succeeds.
template <typename Action>
Status guarded(const Action& action) {
  try {
    return action();
  } catch (const InputError& error) {
    return {error.code(), error.what()};
  } catch (const std::exception& error) {
    return {Code::kInternal, error.what()};
  }
}

template <typename Request, typename Response, typename Handler>
ros::ServiceServer serve(ros::NodeHandle nh, const std::string& name, Handler handler) {
  auto options = careful_service<Request, Response>(name, [handler](Request& request, Response& response) {
    handler(request, &response);
    return true;
  });
  return nh.advertiseService(options);
}

/// std_srvs answer with success and message.
template <typename Response>
void fill_std(const Status& status, Response* response) {
  response->success = status.ok();
  response->message = status.message;
}

}  // namespace deformable_sim
