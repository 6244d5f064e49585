// Messages whose sizes are believed only as far as their bytes go.
//
// A ROS message says how many items each of its lists has. roscpp makes room for as many before it reads the first: a
// message of 20 bytes that claims 2^32 poses takes memory until there is none. Here a list is refused when the bytes
// that are left cannot hold it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <ros/advertise_service_options.h>
#include <ros/serialization.h>
#include <ros/service_callback_helper.h>
#include <ros/subscribe_options.h>
#include <ros/subscription_callback_helper.h>
#include <boost/array.hpp>
#include <boost/make_shared.hpp>

namespace deformable_sim {

/// Reads as ros::serialization::IStream does, for Serializer<M>::read(). Throws
/// ros::serialization::StreamOverrunException, which roscpp logs, and drops the message.
class CarefulStream : public ros::serialization::IStream {
 public:
  CarefulStream(std::uint8_t* bytes, std::uint32_t size) : IStream(bytes, size) {}

  template <typename T>
  void next(T& value) {
    ros::serialization::Serializer<T>::read(*this, value);
  }
  void next(std::string& text) {
    const std::uint32_t size = length(1);
    const char* bytes = reinterpret_cast<const char*>(advance(size));
    text.assign(bytes, size);
  }
  template <typename T, typename Allocator>
  void next(std::vector<T, Allocator>& items) {
    items.resize(length(ros::serialization::serializationLength(T())));  // no item is shorter than an empty one
    for (T& item : items) next(item);
  }
  template <typename T, std::size_t N>
  void next(boost::array<T, N>& items) {
    for (T& item : items) next(item);
  }

 private:
  /// The number of items that follow, each of so many bytes or more.
  std::uint32_t length(std::uint32_t bytes_each) {
    std::uint32_t count = 0;
    IStream::next(count);
    if (count > getLength() / std::max(bytes_each, 1U)) ros::serialization::throwStreamOverrun();
    return count;
  }
};

template <typename M>
boost::shared_ptr<M> read_carefully(std::uint8_t* bytes, std::uint32_t size) {
  const boost::shared_ptr<M> message = boost::make_shared<M>();
  CarefulStream stream(bytes, size);
  ros::serialization::Serializer<M>::read(stream, *message);
  return message;
}

/// What reads messages of a topic in place of roscpp's own.
template <typename M>
class CarefulSubscription : public ros::SubscriptionCallbackHelperT<const boost::shared_ptr<const M>&> {
 public:
  using ros::SubscriptionCallbackHelperT<const boost::shared_ptr<const M>&>::SubscriptionCallbackHelperT;

  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& params) override {
    return read_carefully<M>(params.buffer, params.length);
  }
};

/// For NodeHandle::subscribe().
template <typename M>
ros::SubscribeOptions careful_subscription(const std::string& topic, std::uint32_t queue,
                                           const boost::function<void(const boost::shared_ptr<const M>&)>& callback) {
  ros::SubscribeOptions options(topic, queue, ros::message_traits::md5sum<M>(), ros::message_traits::datatype<M>());
  options.helper = boost::make_shared<CarefulSubscription<M>>(callback);
  return options;
}

/// What reads the requests of a service in place of roscpp's own.
template <typename Request, typename Response>
class CarefulService : public ros::ServiceCallbackHelper {
 public:
  using Callback = boost::function<bool(Request&, Response&)>;
  explicit CarefulService(Callback callback) : callback_(std::move(callback)) {}

  bool call(ros::ServiceCallbackHelperCallParams& params) override {
    const ros::SerializedMessage& bytes = params.request;
    const std::size_t size = bytes.num_bytes - static_cast<std::size_t>(bytes.message_start - bytes.buf.get());
    const auto request = read_carefully<Request>(bytes.message_start, static_cast<std::uint32_t>(size));
    Response response;
    const bool ok = callback_(*request, response);
    params.response = ros::serialization::serializeServiceResponse(ok, response);
    return ok;
  }

 private:
  Callback callback_;
};

/// For NodeHandle::advertiseService().
template <typename Request, typename Response>
ros::AdvertiseServiceOptions careful_service(const std::string& name,
                                             typename CarefulService<Request, Response>::Callback callback) {
  ros::AdvertiseServiceOptions options;
  options.service = name;
  options.md5sum = ros::service_traits::md5sum<Request>();
  options.datatype = ros::service_traits::datatype<Request>();
  options.req_datatype = ros::message_traits::datatype<Request>();
  options.res_datatype = ros::message_traits::datatype<Response>();
  options.helper = boost::make_shared<CarefulService<Request, Response>>(std::move(callback));
  return options;
}

}  // namespace deformable_sim
