#include "deformable_sim/ros/master_watch.h"

#include <ros/connection_manager.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/publication.h>
#include <ros/this_node.h>
#include <ros/topic_manager.h>
#include <ros/xmlrpc_manager.h>

namespace deformable_sim {

namespace {

template <typename... Text>
bool call(const std::string& method, XmlRpc::XmlRpcValue* answer, const Text&... arguments) {
  XmlRpc::XmlRpcValue request, response;
  int i = 0;
  request[i++] = ros::this_node::getName();
  ((request[i++] = arguments), ...);
  return ros::master::execute(method, request, response, *answer, false);
}

/// What the master would tell us when publishers came: roscpp has no other door for it than its own XML-RPC server.
void tell_publishers(const std::string& topic, const XmlRpc::XmlRpcValue& publishers) {
  const ros::XMLRPCManagerPtr& manager = ros::XMLRPCManager::instance();
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(manager->getServerURI(), host, port)) return;
  XmlRpc::XmlRpcValue request, response;
  request[0] = "/master";
  request[1] = topic;
  request[2] = publishers;
  XmlRpc::XmlRpcClient* client = manager->getXMLRPCClient(host, static_cast<int>(port), "/");
  if (!client) return;
  client->execute("publisherUpdate", request, response);
  manager->releaseXMLRPCClient(client);
}

/// Whether the master has taken all of it.
bool register_again(const std::vector<std::string>& services, const std::string& service_uri) {
  const std::string uri = ros::XMLRPCManager::instance()->getServerURI();
  XmlRpc::XmlRpcValue answer;
  bool complete = true;
  ros::V_string topics;
  ros::this_node::getAdvertisedTopics(topics);
  for (const std::string& topic : topics) {
    const ros::PublicationPtr publication = ros::TopicManager::instance()->lookupPublication(topic);
    if (publication) complete &= call("registerPublisher", &answer, topic, publication->getDataType(), uri);
  }
  topics.clear();
  ros::this_node::getSubscribedTopics(topics);
  for (const std::string& topic : topics) {
    if (call("registerSubscriber", &answer, topic, std::string("*"), uri)) {
      tell_publishers(topic, answer);
    } else {
      complete = false;
    }
  }
  std::vector<std::string> all = services;
  all.push_back(ros::this_node::getName() + "/get_loggers");
  all.push_back(ros::this_node::getName() + "/set_logger_level");
  for (const std::string& service : all) complete &= call("registerService", &answer, service, service_uri, uri);
  return complete;
}

}  // namespace

MasterWatch::MasterWatch() {
  // Not when it is needed: once roscpp shuts down, asking for the port ends the program.
  if (ros::isShuttingDown()) return;
  service_uri_ =
      "rosrpc://" + ros::network::getHost() + ":" + std::to_string(ros::ConnectionManager::instance()->getTCPPort());
}

void MasterWatch::check(const std::vector<std::string>& services) {
  if (!ros::master::check()) {
    if (!lost_)
      ROS_WARN_NAMED("master", "the ROS master is gone; the simulation goes on and registers again when it is back");
    lost_ = true;
    return;
  }
  // Not lookupNode: a topic that was advertised since makes a new master know the node, and nothing else of it.
  XmlRpc::XmlRpcValue answer;
  if (incomplete_ || !call("lookupService", &answer, services.front())) {
    // A node that ends unregisters itself.
    if (ros::isShuttingDown()) return;
    incomplete_ = !register_again(services, service_uri_);
    if (incomplete_) return;
    ROS_WARN_NAMED("master", "the ROS master did not know this node; all topics and services are registered again");
  }
  lost_ = false;
}

}  // namespace deformable_sim
